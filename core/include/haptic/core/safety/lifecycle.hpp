#pragma once
/// The device's state machine and its one gain g (proto/README.md#states-of-a-device). Table and
/// rules only: the caller says what happened in the tick, this says which state follows and how g
/// may move.
///
///   INIT -> IDLE -> ARMED -> ENGAGING -> ENGAGED
///                     ^         |           |  Release, end of lease, preemption, SIGTERM
///                     |         v           v
///                     +------ RELEASING <---+        any but INIT, CLOSING -> FAULT -> IDLE
///   INIT, IDLE, ARMED, FAULT (and RELEASING at g = 0) -> CLOSING on SIGTERM

#include <cstdint>
#include <string_view>

#include "haptic/core/time.hpp"

namespace haptic::core {

enum class LifecycleState : std::uint8_t {
  kInit = 1,
  kIdle = 2,
  kArmed = 3,
  kEngaging = 4,
  kEngaged = 5,
  kReleasing = 6,
  kFault = 7,
  kClosing = 8,
};

[[nodiscard]] std::string_view name(LifecycleState state) noexcept;  ///< "ENGAGED", ...
/// The elastic force may be other than 0 in this state.
[[nodiscard]] constexpr bool carries_force(LifecycleState state) noexcept {
  return state == LifecycleState::kEngaging || state == LifecycleState::kEngaged ||
         state == LifecycleState::kReleasing;
}

/// Events that a tick knows when it asks for the next state. Several may hold at once: a fault wins
/// over everything, the end of force (closing, release, lease) over its loss, loss over progress.
struct StateEvents {
  bool fault{false};    ///< any fault is latched
  bool closing{false};  ///< SIGTERM was received
  bool lease_held{false};
  bool lease_changed{false};  ///< another tenure: preempted, or taken again
  bool armed{false};          ///< the device says it would follow
  bool ready{false};          ///< device open, q finite and in range
  bool engage{false};         ///< an Engage was accepted in this tick
  bool release{false};        ///< a Release was asked for in this tick
  bool lost{false};           ///< age of the proxy >= fade_end
};

class LifecycleMachine {
 public:
  /// One step; `g` is the gain of the previous tick.
  LifecycleState step(const StateEvents& events, double g) noexcept;
  [[nodiscard]] LifecycleState state() const noexcept { return state_; }
  /// The device should be armed in this state.
  [[nodiscard]] bool wants_armed() const noexcept;
  /// ENGAGING or ENGAGED was left because the proxy was lost, in the last step.
  [[nodiscard]] bool lost_now() const noexcept { return lost_now_; }

 private:
  LifecycleState state_{LifecycleState::kInit};
  bool lost_now_{false};
  bool lease_held_{false};
};

/// g and its rates: up at most dt/200 ms, down at most dt/(fade_end - hold_end), never above the
/// ladder. Every recovery is therefore a ramp.
class Gain {
 public:
  static constexpr Duration kRise{std::chrono::milliseconds(200)};
  /// `wanted`: the state is ENGAGING or ENGAGED (and the device is not in a gap of its recording).
  double step(bool wanted, double ladder, Duration dt, Duration fall) noexcept;
  [[nodiscard]] double value() const noexcept { return g_; }
  void zero() noexcept { g_ = 0.0; }

 private:
  double g_{0.0};
};

}  // namespace haptic::core
