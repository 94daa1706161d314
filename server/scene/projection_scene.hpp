#pragma once
/// What a device's scene says about its projection: the metric W_x and the prior.

#include "haptic/core/projection/projection_model.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// Reads metric and prior of a device whose path is `path`, and fills in their
/// defaults. Reports metres beside radians without a metric, and a map that x
/// does not determine without a prior. `kinematics` null: wrong, nothing is
/// looked at.
[[nodiscard]] core::ProjectionSettings read_projection(v1::DeviceScene& message,
                                                       const std::string& path,
                                                       const core::Kinematics* kinematics,
                                                       Problems& problems);

}  // namespace haptic::server
