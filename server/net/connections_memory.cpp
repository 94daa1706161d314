/// Connections: what gives way when the memory of the process grows.

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <tuple>
#include <utility>

#include "server/net/connection.hpp"

namespace haptic::server {
namespace {

constexpr std::chrono::seconds kMemoryEvery{1};
/// Who owes less did not make the memory grow.
constexpr double kSuspect = 2 * 1024;

}  // namespace

std::uint64_t Connections::resident() const {
  std::array<char, 64> text{};
  if (pread(statm_.get(), text.data(), text.size() - 1, 0) <= 0) return 0;
  unsigned long long pages = 0;
  static_cast<void>(std::sscanf(text.data(), "%*u %llu", &pages));
  return pages * static_cast<unsigned long long>(sysconf(_SC_PAGESIZE));
}

void Connections::look_at_memory(core::TimePoint now) {
  const std::uint64_t size = resident();
  if (size > resident_ + limits_.growth && resident_ != 0) {
    // A few bytes may cost gRPC a thousand times as much: a stream that is taken back at once.
    double most = kSuspect;
    for (const auto& each : open_) most = std::max(most, each->debt.bytes());
    for (const auto& each : open_) {
      if (each->debt.bytes() >= 0.5 * most)
        offends(*each, "sent the bytes that the memory grew by");
    }
    resident_ = size;
  }
  if (now - memory_at_ < kMemoryEvery) return;
  memory_at_ = now;
  // What an attack leaves behind is given back.
  if (std::exchange(trim_, false)) malloc_trim(0);
  resident_ = size;
  if (size <= limits_.memory) return;
  const struct mallinfo2 heap = mallinfo2();
  if (heap.uordblks + heap.hblkhd <= limits_.memory) return;
  const auto most = std::max_element(open_.begin(), open_.end(), [](const auto& a, const auto& b) {
    return std::tuple(!a->over, a->debt.unexplained()) <
           std::tuple(!b->over, b->debt.unexplained());
  });
  if (most == open_.end() || (*most)->over) return;
  offends(**most, "was the likeliest cause of the memory in use");
}

}  // namespace haptic::server
