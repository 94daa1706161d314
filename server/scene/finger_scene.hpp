#pragma once
/// The dimensions of a finger exoskeleton, as three kinematics have them.

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// Fills in the defaults of the message, whose path is `path`.
[[nodiscard]] core::FingerDimensions read_dimensions(v1::FingerExoskeletonScene& message,
                                                     const std::string& path, Problems& problems);

}  // namespace haptic::server
