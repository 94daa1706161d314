#pragma once
/// Reads force_control of a device.

#include "haptic/core/model/kinematics.hpp"
#include "haptic/v1/scene.pb.h"
#include "hw/board/calibration.hpp"
#include "server/scene/force_control.hpp"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// Reads the message of a device whose path is `path` and fills in its defaults. `kinematics` may be
/// null: not known, sizes are not looked at. `calibration`, null: none; an admittance keeps within its
/// travel. `force_limit`, `max_effort`: n_a, or empty.
[[nodiscard]] ForceControlScene read_force_control(
    v1::DeviceScene& device, const std::string& device_path, const core::Kinematics* kinematics,
    const hw::board::Calibration* calibration, const core::VecA& force_limit,
    const core::VecA& max_effort, Problems& problems);

}  // namespace haptic::server
