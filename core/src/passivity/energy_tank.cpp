#include "haptic/core/passivity/energy_tank.hpp"

#include <algorithm>

namespace haptic::core {

void EnergyTank::refill(double dt, const HoldAccount& account) noexcept {
  // Physical damping is never credited: it pays the hold's leak, and only that.
  const double unpaid_leak = std::max(0.0, account.leak - account.device_damping);
  level_ = std::min(
      level_ + settings_.allowed_power * dt + account.limits + account.rendered - unpaid_leak,
      settings_.capacity);
}

double EnergyTank::admit(double before, const SpringStorage& after, const VecA& d) noexcept {
  const double allowed = before + level_;
  const double wanted = after.energy(d);
  if (wanted <= allowed + kRounding ||
      wanted == 0.0) {  // where there is no spring, nothing is held
    level_ = std::min(allowed - wanted, settings_.capacity);
    return 1.0;
  }
  level_ = std::min(allowed, 0.0);
  return after.scale_to(d, allowed);
}

}  // namespace haptic::core
