#pragma once
/// Limits of an actuator beyond its largest force: power, rate, temperature. Each narrows the
/// range in which the force of this tick may lie; none of them ever makes a force grow, and none
/// takes away a force that brakes. Less force in the direction of motion is less energy given out.

#include <limits>
#include <optional>

#include "haptic/core/fault.hpp"
#include "haptic/core/safety/thermal_model.hpp"

namespace haptic::core {

/// Ratings of one actuated DoF. A rating that is not given does not limit.
struct ActuatorRatings {
  double power{std::numeric_limits<double>::infinity()};  ///< W of mechanical power given out, > 0
  double rate{std::numeric_limits<double>::infinity()};   ///< m/s or rad/s, > 0
  std::optional<ThermalParameters> thermal{};

  [[nodiscard]] bool any() const noexcept {
    return power < std::numeric_limits<double>::infinity() ||
           rate < std::numeric_limits<double>::infinity() || thermal.has_value();
  }
};

/// nullptr if the ratings are consistent; else what is wrong.
[[nodiscard]] const char* check(const ActuatorRatings& ratings) noexcept;

/// The forces allowed in a tick, N or N m, and which limiter set either end. 0 is always inside.
struct ForceRange {
  double lower{-std::numeric_limits<double>::infinity()};
  double upper{std::numeric_limits<double>::infinity()};
  Limiter lower_by{Limiter::kSaturation};
  Limiter upper_by{Limiter::kSaturation};
};

/// Share of the rate limit below which the force is not changed. Between here and the limit a force
/// along the motion falls linearly to 0; one that is simply cut at the limit would chatter.
inline constexpr double kFullForceBelow = 0.8;

/// tau v <= ratings.power, and no push beyond ratings.rate. `rate`: of the DoF now, m/s or rad/s;
/// `force_limit`: what is allowed at rest, > 0.
[[nodiscard]] ForceRange moving_range(const ActuatorRatings& ratings, double rate,
                                      double force_limit) noexcept;

}  // namespace haptic::core
