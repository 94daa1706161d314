#include <algorithm>

#include "tests/fuzz/targets.hpp"

namespace haptic::test {

FuzzInput FuzzReader::take(std::size_t size) {
  const FuzzInput taken = rest_.first(std::min(size, rest_.size()));
  rest_ = rest_.subspan(taken.size());
  return taken;
}

std::uint8_t FuzzReader::byte() {
  const FuzzInput one = take(1);
  return one.empty() ? std::uint8_t{0} : one.front();
}

std::uint64_t FuzzReader::number(int bytes) {
  std::uint64_t value = 0;
  for (int i = 0; i < bytes; ++i) value = value << 8U | byte();
  return value;
}

}  // namespace haptic::test
