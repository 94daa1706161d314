#include "haptic/core/passivity/energy_tank.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

/// K T^2 / M_a of the stiffest spring that is lent: 10000 N/m at 50 g and 1 ms. M_a would swing on
/// it in 14 ticks, so its force changes over several of them.
constexpr double kStiffest = 0.2;

/// The share of d, 0 to 1, whose force may be lent with `left` J.
double lent(double left, const SpringStorage& after, const VecA& d, const Motion& motion) noexcept {
  if (!(left > 0.0)) return 0.0;
  const VecA tau = after.force(d);
  const double stored = motion.stored(tau);
  double share = stored > left ? std::sqrt(left / stored) : 1.0;
  const double coming = motion.coming(VecA(share * tau));
  if (coming > left) share *= left / coming;
  return share < 1.0 ? share * after.relief(d) : 1.0;
}

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
    const double rise = way * (tau[i] - held[i]) * kick[i];
    sum += std::max(0.0, way * tau[i] * (way * dq[i] + std::max(0.0, rise)));
  }
  return sum;
}

double Motion::stored(const VecA& tau) const noexcept {
  return tau.cwiseAbs2().dot(kick) / kStiffest;
}

double EnergyTank::admit(double before, const SpringStorage& after, const VecA& d,
                         const Motion* motion, double contacts) noexcept {
  const double allowed = before + (level_ + contacts_);
  contacts_ = 0.0;
  const double wanted = after.energy(d);
  if (wanted <= allowed + kRounding ||
      wanted == 0.0) {  // where there is no spring, nothing is held
    keep(allowed - wanted, contacts);
    return 1.0;
  }
  // More is stored than is there, but what counts is what is given.
  const double paid = after.scale_to(d, allowed);
  const double share = motion != nullptr ? lent(allowed, after, d, *motion) : 0.0;
  if (!(share > paid)) {
    level_ = std::min(allowed, 0.0);
    return paid;
  }
  level_ = allowed - after.energy(VecA(share * d));
  return share;
}

void EnergyTank::keep(double left, double contacts) noexcept {
  contacts_ = std::clamp(left, 0.0, std::max(contacts, 0.0));
  level_ = std::min(left - contacts_, settings_.capacity);
}

}  // namespace haptic::core
