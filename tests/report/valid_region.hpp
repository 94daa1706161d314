#pragma once
/// The finger's valid region, core/METHOD.md#finger-linkage: the box, the sliders and the joints'
/// own range.

#include <random>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/support/finger_pose.hpp"

namespace haptic::report {

[[nodiscard]] bool in_valid_region(const core::FingerDimensions& dimensions,
                                   const core::FingerPose& pose);

/// A pose of the region, uniform in (l_x, q_B).
[[nodiscard]] core::VecQ random_pose(std::mt19937_64& random);

}  // namespace haptic::report
