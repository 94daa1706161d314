#include "haptic/core/safety/actuator_limits.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

const char* check(const ActuatorRatings& ratings) noexcept {
  if (!(ratings.power > 0.0)) return "power must be > 0";
  if (!(ratings.rate > 0.0)) return "rate must be > 0";
  return ratings.thermal ? check(*ratings.thermal) : nullptr;
}

ForceRange moving_range(const ActuatorRatings& ratings, double rate, double force_limit) noexcept {
  ForceRange range;
  const double speed = std::abs(rate);
  if (!(speed > 0.0)) return range;  // also where the rate is not known

  double allowed = std::numeric_limits<double>::infinity();
  Limiter by = Limiter::kSaturation;
  if (ratings.power < std::numeric_limits<double>::infinity()) {
    allowed = ratings.power / speed;
    by = Limiter::kPower;
  }
  if (speed > kFullForceBelow * ratings.rate) {
    const double room = (ratings.rate - speed) / ((1.0 - kFullForceBelow) * ratings.rate);
    const double pushing = force_limit * std::max(0.0, room);
    if (pushing < allowed) {
      allowed = pushing;
      by = Limiter::kRate;
    }
  }
  if (rate > 0.0) {
    range.upper = allowed;
    range.upper_by = by;
  } else {
    range.lower = -allowed;
    range.lower_by = by;
  }
  return range;
}

}  // namespace haptic::core
