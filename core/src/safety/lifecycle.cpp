#include "haptic/core/safety/lifecycle.hpp"

#include <algorithm>

#include "haptic/core/names.hpp"

namespace haptic::core {

std::string_view name(LifecycleState state) noexcept {
  static constexpr std::array<std::string_view, 9> kNames{
      "UNKNOWN", "INIT", "IDLE", "ARMED", "ENGAGING", "ENGAGED", "RELEASING", "FAULT", "CLOSING"};
  return name_of(state, kNames);
}

LifecycleState LifecycleMachine::step(const StateEvents& e, double g) noexcept {
  lost_now_ = false;
  lease_held_ = e.lease_held;
  const LifecycleState from = state_;

  if (e.fault && from != LifecycleState::kInit && from != LifecycleState::kClosing &&
      from != LifecycleState::kFault) {
    return state_ = LifecycleState::kFault;
  }

  switch (from) {
    case LifecycleState::kInit:
      if (e.closing) return state_ = LifecycleState::kClosing;
      if (e.ready) return state_ = LifecycleState::kIdle;
      break;
    case LifecycleState::kIdle:
      if (e.closing) return state_ = LifecycleState::kClosing;
      if (e.lease_held && e.armed) return state_ = LifecycleState::kArmed;
      break;
    case LifecycleState::kArmed:
      if (e.closing) return state_ = LifecycleState::kClosing;
      if (!e.lease_held || !e.armed) return state_ = LifecycleState::kIdle;
      if (e.engage) return state_ = LifecycleState::kEngaging;
      break;
    case LifecycleState::kEngaging:
    case LifecycleState::kEngaged:
      if (e.closing || e.release || !e.lease_held || e.lease_changed || !e.armed) {
        return state_ = LifecycleState::kReleasing;
      }
      if (e.lost) {
        lost_now_ = true;
        return state_ = LifecycleState::kArmed;
      }
      if (from == LifecycleState::kEngaging && g >= 1.0) return state_ = LifecycleState::kEngaged;
      break;
    case LifecycleState::kReleasing:
      if (g > 0.0) break;
      if (e.closing) return state_ = LifecycleState::kClosing;
      return state_ = e.lease_held && e.armed ? LifecycleState::kArmed : LifecycleState::kIdle;
    case LifecycleState::kFault:
      if (e.closing) return state_ = LifecycleState::kClosing;
      if (!e.fault) return state_ = LifecycleState::kIdle;
      break;
    case LifecycleState::kClosing:
      break;
  }
  return state_;
}

bool LifecycleMachine::wants_armed() const noexcept {
  if (state_ == LifecycleState::kIdle) return lease_held_;
  return state_ == LifecycleState::kArmed || carries_force(state_);
}

double Gain::step(bool wanted, double ladder, Duration dt, Duration fall) noexcept {
  const double elapsed = seconds(dt);
  g_ = wanted ? std::min(1.0, g_ + elapsed / seconds(kRise))
              : std::max(0.0, g_ - elapsed / seconds(fall));
  return g_ = std::min(g_, ladder);
}

}  // namespace haptic::core
