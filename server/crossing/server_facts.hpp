#pragma once
/// What the server says of itself in GetServerInfo, as the composition root knows it.

#include <cstdint>
#include <functional>
#include <string>

#include "haptic/core/time.hpp"

namespace haptic::server {

/// What of real-time behaviour was asked for and what the host granted.
struct RealtimeFacts {
  std::string requested{};  ///< "require", "try", "off"
  bool sched_fifo{false};
  int priority{0};  ///< 0 where sched_fifo is false
  bool memory_locked{false};
  bool timer_slack{false};  ///< 1 ns
  int cpu{-1};              ///< -1: not pinned
  std::string grade{};      ///< "real-time", "degraded", "best-effort"
  std::string explanation{};
};

/// Percentiles over the last 10 s.
struct LoopFacts {
  std::uint64_t ticks{0};
  std::uint64_t skipped{0};
  double lateness_p50_us{0.0}, lateness_p99_us{0.0}, lateness_max_us{0.0};
  double tick_p50_us{0.0}, tick_p99_us{0.0};
  std::uint64_t records_dropped{0};
  std::uint64_t paced_by_sample{0};  ///< ticks begun by a sample of `paced_by`
  std::string paced_by{};            ///< empty: the timer begins every tick
};

struct ServerFacts {
  std::string version{};
  std::string scene{};
  RealtimeFacts realtime{};
  LoopFacts loop{};
  core::Duration uptime{0};
};

/// Called on gRPC's threads for every GetServerInfo; must not block for long.
using FactsProvider = std::function<ServerFacts()>;

}  // namespace haptic::server
