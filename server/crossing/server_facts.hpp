#pragma once
/// The server's answer to GetServerInfo, as the composition root knows it.

#include <cstdint>
#include <functional>

#include "haptic/core/time.hpp"
#include "server/base/rolling_histogram.hpp"
#include "server/crossing/text.hpp"

namespace haptic::server {

/// Real-time rights that were asked for, and those that the host granted.
struct RealtimeFacts {
  Text<8> requested{};  ///< "require", "try", "off"
  bool sched_fifo{false};
  int priority{0};  ///< 0 unless sched_fifo
  bool memory_locked{false};
  bool timer_slack{false};  ///< 1 ns
  int cpu{-1};              ///< -1: not pinned
  Text<16> grade{};         ///< "real-time", "degraded", "best-effort"
  Text<1500> explanation{};
};

struct LoopFacts {
  std::uint64_t ticks{0};
  std::uint64_t skipped{0};
  std::uint64_t paced_by_sample{0};  ///< ticks begun by a sample; the others by the timer
  Percentiles lateness{};
  Percentiles tick_time{};  ///< from the wake-up to the end of the tick, all units, and the ring
  // The App's.
  std::uint64_t records_dropped{0};
  Text<64> paced_by{};  ///< the device whose samples begin ticks; empty: the timer does
};

struct ServerFacts {
  Text<32> version{};
  Text<128> scene{};
  RealtimeFacts realtime{};
  LoopFacts loop{};
  core::Duration uptime{0};
  std::uint64_t resident_bytes{0};  ///< of the owner's process
  std::uint64_t fronts_served{0};   ///< since the start
};
static_assert(std::is_trivially_copyable_v<ServerFacts> && std::is_standard_layout_v<ServerFacts>);

/// Called on gRPC's threads for every GetServerInfo; must not block for long.
using FactsProvider = std::function<ServerFacts()>;

}  // namespace haptic::server
