#include "haptic/core/control/force_loop.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"

namespace haptic::core {

ForceLoop::ForceLoop(const ForceLoopGains& gains) : gains_(gains) {
  require(gains.proportional >= 0.0, "force_loop.proportional", gains.proportional, ">= 0");
  require(gains.integral >= 0.0, "force_loop.integral", gains.integral, ">= 0");
  require(gains.friction >= 0.0, "force_loop.friction", gains.friction, ">= 0");
  require(gains.friction_band > 0.0, "force_loop.friction_band", gains.friction_band, "> 0");
  require(gains.output_limit > 0.0, "force_loop.output_limit", gains.output_limit, "> 0");
}

/// In the order of ForceLimiter: limit, change, and last what ends a force in time.
double ForceLoop::held(double wanted, double limit, const DriveBounds& bounds) const noexcept {
  const double saturated = std::clamp(wanted, -limit, limit);
  const double slewed = std::clamp(saturated, last_ - bounds.change, last_ + bounds.change);
  return slewed > 0.0 ? std::min(slewed, std::max(saturated, 0.0) + bounds.excess)
                      : std::max(slewed, std::min(saturated, 0.0) - bounds.excess);
}

double ForceLoop::step(double reference, double measured, double dt,
                       const DriveBounds& bounds) noexcept {
  const double e = reference - measured;
  saturated_ = slewed_ = false;
  if (!std::isfinite(e)) return last_ = 0.0;
  const double friction = gains_.friction * std::clamp(e / gains_.friction_band, -1.0, 1.0);
  const double direct = reference + gains_.proportional * e + friction;
  const double limit = std::min(gains_.output_limit, bounds.force);
  const double grown = integral_ + gains_.integral * e * dt;
  const double wanted = direct + grown;
  // While u is held, only what leads back is integrated.
  const double given = held(wanted, limit, bounds);
  const bool deeper = (wanted > given && e > 0.0) || (wanted < given && e < 0.0);
  if (!deeper) integral_ = grown;
  const double u = direct + integral_;
  last_ = held(u, limit, bounds);
  saturated_ = std::abs(u) > limit || (deeper && std::abs(wanted) > limit);
  slewed_ = last_ != std::clamp(u, -limit, limit);
  return last_;
}

void ForceLoop::reset() noexcept {
  integral_ = last_ = 0.0;
  saturated_ = slewed_ = false;
}

}  // namespace haptic::core
