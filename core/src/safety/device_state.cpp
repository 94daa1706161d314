#include "haptic/core/safety/device_state.hpp"

#include <algorithm>

namespace haptic::core {

std::string_view name(DeviceState state) noexcept {
  switch (state) {
    case DeviceState::kInit:
      return "INIT";
    case DeviceState::kIdle:
      return "IDLE";
    case DeviceState::kArmed:
      return "ARMED";
    case DeviceState::kEngaging:
      return "ENGAGING";
    case DeviceState::kEngaged:
      return "ENGAGED";
    case DeviceState::kReleasing:
      return "RELEASING";
    case DeviceState::kFault:
      return "FAULT";
    case DeviceState::kClosing:
      return "CLOSING";
  }
  return "UNKNOWN";
}

DeviceState DeviceStateMachine::step(const StateEvents& e, double g) noexcept {
  lost_now_ = false;
  lease_held_ = e.lease_held;
  const DeviceState from = state_;

  if (e.fault && from != DeviceState::kInit && from != DeviceState::kClosing &&
      from != DeviceState::kFault) {
    return state_ = DeviceState::kFault;
  }

  switch (from) {
    case DeviceState::kInit:
      if (e.closing) return state_ = DeviceState::kClosing;
      if (e.ready) return state_ = DeviceState::kIdle;
      break;
    case DeviceState::kIdle:
      if (e.closing) return state_ = DeviceState::kClosing;
      if (e.lease_held && e.armed) return state_ = DeviceState::kArmed;
      break;
    case DeviceState::kArmed:
      if (e.closing) return state_ = DeviceState::kClosing;
      if (!e.lease_held || !e.armed) return state_ = DeviceState::kIdle;
      if (e.engage) return state_ = DeviceState::kEngaging;
      break;
    case DeviceState::kEngaging:
    case DeviceState::kEngaged:
      if (e.closing || e.release || !e.lease_held || e.lease_changed || !e.armed) {
        return state_ = DeviceState::kReleasing;
      }
      if (e.lost) {
        lost_now_ = true;
        return state_ = DeviceState::kArmed;
      }
      if (from == DeviceState::kEngaging && g >= 1.0) return state_ = DeviceState::kEngaged;
      break;
    case DeviceState::kReleasing:
      if (g > 0.0) break;
      if (e.closing) return state_ = DeviceState::kClosing;
      return state_ = e.lease_held && e.armed ? DeviceState::kArmed : DeviceState::kIdle;
    case DeviceState::kFault:
      if (e.closing) return state_ = DeviceState::kClosing;
      if (!e.fault) return state_ = DeviceState::kIdle;
      break;
    case DeviceState::kClosing:
      break;
  }
  return state_;
}

bool DeviceStateMachine::wants_armed() const noexcept {
  switch (state_) {
    case DeviceState::kIdle:
      return lease_held_;
    case DeviceState::kArmed:
    case DeviceState::kEngaging:
    case DeviceState::kEngaged:
    case DeviceState::kReleasing:
      return true;
    default:
      return false;
  }
}

double Gain::step(bool wanted, double ladder, Duration dt, Duration fall) noexcept {
  const double elapsed = seconds(dt);
  g_ = wanted ? std::min(1.0, g_ + elapsed / seconds(kRise))
              : std::max(0.0, g_ - elapsed / seconds(fall));
  return g_ = std::min(g_, ladder);
}

}  // namespace haptic::core
