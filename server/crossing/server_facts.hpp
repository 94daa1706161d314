#pragma once
/// The server's answer to GetServerInfo, as the composition root knows it.

#include <cstdint>
#include <functional>

#include "haptic/core/time.hpp"
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

/// Percentiles over the last 10 s.
struct LoopFacts {
  std::uint64_t ticks{0};
  std::uint64_t skipped{0};
  double lateness_p50_us{0.0}, lateness_p99_us{0.0}, lateness_max_us{0.0};
  double tick_p50_us{0.0}, tick_p99_us{0.0};
  std::uint64_t records_dropped{0};
  std::uint64_t paced_by_sample{0};  ///< ticks begun by a sample of `paced_by`
  Text<64> paced_by{};               ///< empty: the timer begins every tick
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
