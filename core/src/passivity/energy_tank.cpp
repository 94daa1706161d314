#include "haptic/core/passivity/energy_tank.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

constexpr double kFaster = 2.0;  ///< than it drifts, a device may go on
/// Noise of a sensor seldom moves dq + more by more jitters than that: three times its rms.
constexpr double kJitters = 6.0;

}  // namespace

void EnergyTank::refill(double dt, const HoldAccount& account) noexcept {
  // Physical damping is never credited: it pays the hold's leak, and only that.
  const double unpaid_leak = std::max(0.0, account.leak - account.device_damping);
  level_ = std::min(
      level_ + settings_.allowed_power * dt + account.limits + account.rendered - unpaid_leak,
      settings_.capacity);
}

double Motion::share(const VecA& tau, double left, bool slowly) const noexcept {
  // J: s tau gives at most s goes_on + s^2 faster
  double goes_on = 0.0, faster = slowly ? fading(tau) : 0.0;
  for (Eigen::Index i = 0; i < tau.size(); ++i) {
    if (tau[i] == 0.0) continue;
    const double way = tau[i] < 0.0 ? -1.0 : 1.0;
    const double own = std::max(0.0, way * held[i]) * kick[i];
    double reach = way * dq[i] + std::clamp(way * more[i], 0.0, own);
    if (slowly && jitter.size() > 0) reach = std::max(reach, kJitters * jitter[i]);
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

double Motion::fading(const VecA& tau) const noexcept {
  double power = 0.0;
  for (Eigen::Index i = 0; i < tau.size(); ++i) power += std::max(0.0, tau[i] * drift[i]);
  // In a straight line; s tau takes s times as long, and gives s^2 times as much.
  return 0.5 * kFaster * power * ForceFade::time(tau, limit);
}

double EnergyTank::admit(double before, const SpringStorage& after, const VecA& d,
                         const Motion* motion, double contacts) noexcept {
  const double allowed = before + (level_ + contacts_);
  contacts_ = 0.0;
  const double wanted = after.energy(d);
  // Where there is no spring, nothing is held.
  const bool stored = wanted <= allowed + kRounding || wanted == 0.0;
  if (stored && fade_.share() == 1.0) {
    keep(allowed - wanted, contacts);
    return 1.0;
  }
  // More is stored than is there, but what counts is what is given.
  const double paid = stored ? 1.0 : after.scale_to(d, allowed);
  const double share = motion != nullptr ? eased(allowed, paid, after, d, *motion) : paid;
  if (share == paid && !stored) {
    level_ = std::min(allowed, 0.0);
  } else {
    keep(allowed - after.energy(VecA(share * d)), contacts);
  }
  return share;
}

double EnergyTank::eased(double left, double paid, const SpringStorage& after, const VecA& d,
                         const Motion& motion) noexcept {
  const VecA tau = after.force(d);
  const double relief = after.relief(d);
  const double stored = std::min(1.0, paid / relief);  // as a share of tau
  double lent = 0.0, fading = 0.0;
  if (left > 0.0) {
    lent = motion.share(tau, left);
    fading = motion.share(tau, left, true);
  }
  VecA last = motion.held;
  for (Eigen::Index i = 0; i < tau.size(); ++i) {
    if (!(last[i] * tau[i] > 0.0)) last[i] = 0.0;
  }
  double share = fade_.towards(std::max(stored, fading), ForceFade::time(tau, motion.limit),
                               ForceFade::time(last, motion.limit), motion.tick);
  const double most = std::max(stored, lent);
  if (!(share < most)) share = most;  // also if it is no number
  fade_.at_most(share);
  if (share == stored) return paid;
  return share >= 1.0 ? 1.0 : share * relief;
}

void EnergyTank::keep(double left, double contacts) noexcept {
  contacts_ = std::clamp(left, 0.0, std::max(contacts, 0.0));
  level_ = std::min(left - contacts_, settings_.capacity);
}

}  // namespace haptic::core
