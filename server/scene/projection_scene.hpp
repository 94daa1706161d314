#pragma once
/// The metric W_x and the prior of a device.

#include "haptic/core/projection/projection_model.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// Reads task_metric and prior of the device whose path is `path`, and reports
/// where one of them is needed and absent. `kinematics` null: not known, sizes
/// are not looked at.
[[nodiscard]] core::ProjectionSettings read_projection(v1::DeviceScene& message,
                                                       const std::string& path,
                                                       const core::Kinematics* kinematics,
                                                       Problems& problems);

}  // namespace haptic::server
