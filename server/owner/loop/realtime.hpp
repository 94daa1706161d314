#pragma once
/// Asks the host for real-time behaviour, and reports what it granted.

#include <optional>
#include <string>
#include <string_view>

#include "haptic/core/time.hpp"
#include "server/crossing/server_facts.hpp"
#include "server/owner/loop/realtime_host.hpp"

namespace haptic::server {

enum class RealtimeMode {
  kRequire,  ///< all of it, or the server does not start
  kTry,      ///< what can be had; the rest is reported
  kOff,      ///< nothing is asked for (but the timer slack, which every thread may set)
};

[[nodiscard]] std::string_view name(RealtimeMode mode) noexcept;  ///< "require", "try", "off"

struct RealtimeRequest {
  RealtimeMode mode{RealtimeMode::kTry};
  int priority{80};          ///< SCHED_FIFO, 1..98
  std::optional<int> cpu{};  ///< absent: not pinned
  /// The scene's; absent: 8 ms if SCHED_FIFO was granted, else 20 ms
  /// (proto/README.md#states-of-a-device).
  std::optional<core::Duration> loop_late_fault{};
};

struct RealtimeGrant {
  RealtimeFacts facts{};
  bool may_keep_awake{false};  ///< RealtimeHost::keep_awake() has an effect
  /// The scene's, or the one that goes with what was granted.
  core::Duration loop_late_fault{std::chrono::milliseconds(20)};
};

inline constexpr core::Duration kLateFaultRealtime{std::chrono::milliseconds(8)};
inline constexpr core::Duration kLateFaultElsewhere{std::chrono::milliseconds(20)};

/// Applies `request` to the calling thread (scheduling, timer slack, affinity, stack) and to the
/// process (memory locking). The grade is "real-time" if all that was asked for was granted,
/// "degraded" if some of it was refused or given in part, "best-effort" if nothing was asked
/// for; the explanation says what was granted, what was not and why, and what that means. In mode
/// kRequire throws RealtimeError, with the explanation, if the grade is not "real-time".
[[nodiscard]] RealtimeGrant apply_realtime(const RealtimeRequest& request,
                                           RealtimeHost& host = real_host());

}  // namespace haptic::server
