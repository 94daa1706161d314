#include "haptic/core/passivity/energy_tank.hpp"

#include <algorithm>

namespace haptic::core {

namespace {

/// Per admit(): a force that may no longer be lent is gone in some 20 ticks, not in one.
constexpr double kFade = 0.8;

}  // namespace

void EnergyTank::refill(double dt, const HoldAccount& account) noexcept {
  // Physical damping is never credited: it pays the hold's leak, and only that.
  const double unpaid_leak = std::max(0.0, account.leak - account.device_damping);
  level_ = std::min(
      level_ + settings_.allowed_power * dt + account.limits + account.rendered - unpaid_leak,
      settings_.capacity);
}

double Motion::coming(const VecA& tau) const noexcept {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < tau.size(); ++i) {
    const double way = tau[i] < 0.0 ? -1.0 : 1.0;
    const double on = way * dq[i], faster = way * (dq[i] - dq_before[i]);
    const double rise = way * (tau[i] - held[i]) * kick[i];
    const double most =
        on + std::max(0.0, 0.5 * on) + std::max(0.0, 2.0 * faster) + std::max(0.0, rise);
    sum += std::max(0.0, way * tau[i] * most);
  }
  return sum;
}

double EnergyTank::admit(double before, const SpringStorage& after, const VecA& d,
                         const Motion* motion) noexcept {
  const double allowed = before + level_;
  const double wanted = after.energy(d);
  if (wanted <= allowed + kRounding ||
      wanted == 0.0) {  // where there is no spring, nothing is held
    level_ = std::min(allowed - wanted, settings_.capacity);
    lent_ = 1.0;
    return 1.0;
  }
  // More is stored than is there, but what counts is what the next hold gives.
  const double paid = after.scale_to(d, allowed);
  const double lent = motion != nullptr ? lend(allowed, after, d, *motion) : 0.0;
  if (!(lent > paid)) {
    level_ = std::min(allowed, 0.0);
    return paid;
  }
  level_ = allowed - after.energy(VecA(lent * d));
  return lent;
}

double EnergyTank::lend(double allowed, const SpringStorage& after, const VecA& d,
                        const Motion& motion) noexcept {
  const VecA tau = after.force(d);
  if (lent_ == 1.0 && motion.coming(tau) <= allowed) return 1.0;
  lent_ *= kFade;
  const double coming = motion.coming(VecA(lent_ * tau));
  if (coming > allowed) lent_ *= std::max(0.0, allowed / coming);
  return lent_ * after.relief(d);
}

}  // namespace haptic::core
