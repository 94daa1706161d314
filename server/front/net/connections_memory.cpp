/// Connections: what gives way when the memory of the process grows.

#include <malloc.h>

#include <algorithm>
#include <utility>

#include "server/base/process.hpp"
#include "server/front/net/connection.hpp"

namespace haptic::server {
namespace {

constexpr std::chrono::seconds kMemoryEvery{1};
/// Time between two looks at the heap: each takes malloc's locks.
constexpr std::chrono::milliseconds kHeapEvery{50};
/// gRPC gives back what it has of connections that were cut within such a time, however busy the
/// host is.
constexpr std::chrono::seconds kGivesBack{5};
/// An honest client begins with 3 KB of TLS and a call, and then asks little.
constexpr double kSuspect = 8 * 1024;
constexpr double kAccomplice = 0.125;  ///< of the largest
/// A call that is not over counts as so many bytes that came just now: hardly any is shorter.
constexpr double kBytesOfCall = 64;

std::uint64_t heap_in_use() {
  const struct mallinfo2 heap = mallinfo2();
  return heap.uordblks + heap.hblkhd;
}

}  // namespace

void Connections::look_at_memory(core::TimePoint now) {
  const std::uint64_t size = own_bytes();
  if (resident_ != 0 && size > resident_ + limits_.growth) {
    resident_ = size;
    cut_suspects(now);
  }
  resident_ = std::min(resident_, size);
  const bool drained = full_ && now >= heap_at_ && heap_in_use() <= limits_.memory;
  if (full_ && now >= heap_at_) heap_at_ = now + kHeapEvery;
  if (drained) full_ = false;
  if (!drained && now - memory_at_ < kMemoryEvery) return;
  memory_at_ = now;
  // Memory that an attack leaves behind is given back, so that the next one is seen to grow.
  if (std::exchange(trim_, false)) malloc_trim(0);
  resident_ = own_bytes();
  if (resident_ > limits_.memory && heap_in_use() > limits_.memory) cut_suspects(now);
}

void Connections::cut_suspects(core::TimePoint now) {
  const auto cost = [](const Connection& connection) {
    return connection.suspicion.bytes() + kBytesOfCall * connection.account->calls();
  };
  double most = 0.0;
  for (const auto& each : open_) most = std::max(most, cost(*each));
  if (most < kSuspect) return;
  for (const auto& each : open_) {
    if (cost(*each) >= std::max(kSuspect, kAccomplice * most)) {
      offends(*each, "was a likely cause of the memory in use");
    }
  }
  full_ = true;
  heap_at_ = now + kHeapEvery;
  shut_until_ = now + kGivesBack;
}

}  // namespace haptic::server
