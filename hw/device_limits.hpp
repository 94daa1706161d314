#pragma once
/// What every device of this room derives from its kinematics in the same way.

#include <string>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/tick/pipeline.hpp"

namespace haptic::hw {

/// A sample may stand outside its DoF's box by this share of the box's span before it is a fault:
/// noise and calibration at a mechanical stop are no reason to stop.
inline constexpr double kRangeMargin = 0.05;

/// Range of every DoF with its margin, `max_effort`, one sample per millisecond, at most 10 ms of
/// silence. Throws DeviceError: max_effort of another size than n_a, or a value that is not > 0.
[[nodiscard]] core::DeviceLimits device_limits(const core::Kinematics& kinematics,
                                               const core::VecA& max_effort);

/// Throws DeviceError unless `value` is finite and > 0 (>= 0): "name = value: must be > 0".
void require_positive(const std::string& name, double value);
void require_not_negative(const std::string& name, double value);
void require_finite(const std::string& name, double value);

}  // namespace haptic::hw
