#pragma once
/// Bytes as people write them.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace haptic::test {

using ByteVector = std::vector<std::uint8_t>;

/// Blanks are passed over. Throws std::invalid_argument on anything but hexadecimal digits.
[[nodiscard]] inline ByteVector from_hex(const std::string& text) {
  ByteVector bytes;
  std::string pair;
  for (const char c : text) {
    if (c == ' ') continue;
    pair += c;
    if (pair.size() < 2) continue;
    std::size_t used = 0;
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(pair, &used, 16)));
    if (used != 2) throw std::invalid_argument("not hexadecimal: " + pair);
    pair.clear();
  }
  if (!pair.empty()) throw std::invalid_argument("half a byte at the end");
  return bytes;
}

template <typename Container>
[[nodiscard]] std::string to_hex(const Container& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += "0123456789abcdef"[byte >> 4U];
    text += "0123456789abcdef"[byte & 0xFU];
  }
  return text;
}

}  // namespace haptic::test
