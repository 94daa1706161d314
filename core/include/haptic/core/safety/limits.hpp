#pragma once
/// The last borders before the device, in the order of core/README.md#one-tick: saturation, slew,
/// envelope.

#include "haptic/core/fault.hpp"
#include "haptic/core/safety/actuator_limits.hpp"
#include "haptic/core/time.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

/// lower <= v <= upper in every component. Sizes must agree.
[[nodiscard]] bool within(const VecQ& v, const VecQ& lower, const VecQ& upper) noexcept;

/// The command of one actuated DoF after its limits.
struct LimitedForce {
  double total{0.0};    ///< N or N m
  double damping{0.0};  ///< its damping part; the elastic part is total - damping
};

/// Limits of one actuated DoF over one tick.
///   damping' = slewed and saturated damping
///   total    = clamp(elastic + damping', +-force_limit), slewed from the previous total
///   total    = clamp(total, damping' +- gain * force_limit)             (the envelope)
///   total    = clamp(total, range)                    (power and rate of the actuator)
/// The last two act after the slew limit: at gain 0 the elastic part is exactly 0, however steep
/// that is, a rated power is kept whatever the motion, and neither makes the force grow.
class ForceLimiter {
 public:
  /// `elastic` already carries the gain. slew is N/s (N m/s).
  LimitedForce step(double elastic, double damping, double gain, double force_limit, double slew,
                    Duration dt, LimiterSet& active, const ForceRange& range = {}) noexcept;
  /// Command zero now: a fault, or a device that is not armed.
  void zero() noexcept { previous_ = {}; }

 private:
  LimitedForce previous_{};
};

}  // namespace haptic::core
