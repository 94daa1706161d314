#pragma once
/// What the loop asks of the host: SCHED_FIFO, locked memory, 1 ns of timer slack, one CPU. What was
/// refused is said with the reason and with what it means.

#include <optional>

#include "server/rpc/server_facts.hpp"

namespace haptic::server {

enum class RealtimeMode : std::uint8_t {
  kRequire,  ///< refuse to start without SCHED_FIFO and locked memory
  kTry,      ///< take what is granted, say what was not
  kOff,      ///< ask for nothing
};

struct RealtimeRequest {
  RealtimeMode mode{RealtimeMode::kTry};
  int priority{80};           ///< SCHED_FIFO, 1..98
  std::optional<int> cpu{};   ///< absent: not pinned
};

/// Applies the request to the calling thread and the whole process (memory). Call it on the loop's
/// thread before its first tick. Memory is locked as it is touched (MCL_ONFAULT): locking all of it
/// at once takes an idle gRPC server from 13 to 137 MB. Throws RealtimeError where kRequire is refused.
[[nodiscard]] RealtimeFacts apply_realtime(const RealtimeRequest& request);

}  // namespace haptic::server
