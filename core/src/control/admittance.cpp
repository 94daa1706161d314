#include "haptic/core/control/admittance.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"

namespace haptic::core {

Admittance::Admittance(const AdmittanceParameters& parameters)
    : p_(parameters), position_(parameters.lower) {
  require(p_.mass >= 0.0, "admittance.mass", p_.mass, ">= 0");
  require(p_.damping > 0.0, "admittance.damping", p_.damping, "> 0");
  require(p_.max_rate > 0.0, "admittance.max_rate", p_.max_rate, "> 0");
  require(true, "admittance.lower", p_.lower);
  require(p_.upper > p_.lower, "admittance.upper", p_.upper, "above lower");
}

void Admittance::reset(double position) noexcept {
  position_ = std::isfinite(position) ? std::clamp(position, p_.lower, p_.upper) : p_.lower;
  rate_ = 0.0;
  limited_ = false;
}

double Admittance::step(double reference, double measured, double dt) noexcept {
  const double e = reference - measured;
  limited_ = false;
  if (!std::isfinite(e)) {
    rate_ = 0.0;
    return position_;
  }
  const double free = (p_.mass * rate_ + dt * e) / (p_.mass + dt * p_.damping);
  rate_ = std::clamp(free, -p_.max_rate, p_.max_rate);
  const double moved = position_ + dt * rate_;
  position_ = std::clamp(moved, p_.lower, p_.upper);
  limited_ = rate_ != free || position_ != moved;
  // A stop takes the speed away: otherwise the virtual mass would go on pressing after the turn.
  if (position_ != moved) rate_ = 0.0;
  return position_;
}

}  // namespace haptic::core
