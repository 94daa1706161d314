#pragma once
/// The limits that follow from a kinematics in the same way for every device.

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/tick/pipeline.hpp"

namespace haptic::hw {

/// A sample is a fault if it is outside its DoF's range by more than this share of the range: noise
/// and calibration at a mechanical stop are no reason to stop.
inline constexpr double kRangeMargin = 0.05;

/// Range of every DoF with its margin, `max_effort`, one sample per millisecond, at most 10 ms of
/// silence. Throws DeviceError: max_effort of another size than n_a, or a value that is not > 0.
[[nodiscard]] core::DeviceLimits device_limits(const core::Kinematics& kinematics,
                                               const core::VecA& max_effort);

}  // namespace haptic::hw
