#include "haptic/core/passivity/energy_tank.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

/// The share of d, 0 to 1, whose force may be lent with `left` J.
double lent(double left, const SpringStorage& after, const VecA& d, const Motion& motion) noexcept {
  if (!(left > 0.0)) return 0.0;
  const double share = motion.share(after.force(d), left);
  if (share >= 1.0) return 1.0;
  return share > 0.0 ? share * after.relief(d) : 0.0;  // 0 too if it is no number
}

}  // namespace

void EnergyTank::refill(double dt, const HoldAccount& account) noexcept {
  // Physical damping is never credited: it pays the hold's leak, and only that.
  const double unpaid_leak = std::max(0.0, account.leak - account.device_damping);
  level_ = std::min(
      level_ + settings_.allowed_power * dt + account.limits + account.rendered - unpaid_leak,
      settings_.capacity);
}

double Motion::share(const VecA& tau, double left) const noexcept {
  double goes_on = 0.0, faster = 0.0;  // J: s tau gives at most s goes_on + s^2 faster
  for (Eigen::Index i = 0; i < tau.size(); ++i) {
    if (tau[i] == 0.0) continue;
    const double way = tau[i] < 0.0 ? -1.0 : 1.0;
    const double own = std::max(0.0, way * held[i]) * kick[i];
    const double reach = way * dq[i] + std::clamp(way * more[i], 0.0, own);
    // The force of this hold and of those in which it falls.
    double sum = std::abs(tau[i]);
    if (slew.size() > 0) {
      const double falls = std::floor(sum / slew[i]);
      sum = (falls + 1.0) * (sum - 0.5 * slew[i] * falls);
    }
    goes_on += sum * std::max(0.0, reach);
    faster += sum * sum * kick[i];
  }
  if (goes_on + faster <= left) return 1.0;
  return 2.0 * left / (goes_on + std::sqrt(goes_on * goes_on + 4.0 * faster * left));
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
