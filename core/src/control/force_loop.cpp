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

double ForceLoop::step(double reference, double measured, double dt) noexcept {
  const double e = reference - measured;
  if (!std::isfinite(e)) {
    saturated_ = false;
    return 0.0;
  }
  const double friction = gains_.friction * std::clamp(e / gains_.friction_band, -1.0, 1.0);
  const double direct = reference + gains_.proportional * e + friction;
  const double limit = gains_.output_limit;
  const double grown = integral_ + gains_.integral * e * dt;
  const double wanted = direct + grown;
  // Outside the limits only what leads back inside is integrated.
  const bool deeper = (wanted > limit && e > 0.0) || (wanted < -limit && e < 0.0);
  if (!deeper) integral_ = grown;
  const double u = direct + integral_;
  saturated_ = deeper || std::abs(u) > limit;
  return std::clamp(u, -limit, limit);
}

void ForceLoop::reset() noexcept {
  integral_ = 0.0;
  saturated_ = false;
}

}  // namespace haptic::core
