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
  const double cost = after.energy(d) - before;
  if (cost <= 0.0 || level_ - cost >= -kRounding) {
    level_ = std::min(level_ - cost, settings_.capacity);
    return 1.0;
  }
  const double available = std::max(level_, 0.0);
  level_ -= available;  // all of it; a debt stays
  return after.scale_to(d, before + available);
}

}  // namespace haptic::core
