#pragma once
/// What the actuators can bear beyond their force: power, rate, temperature.

#include <vector>

#include "haptic/core/safety/actuator_limits.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// Reads them from the limits of a device, whose path is `path`, and fills in the defaults of those
/// that are given. Empty where none is. `n_a` -1: not known, sizes are not looked at.
[[nodiscard]] std::vector<core::ActuatorRatings> read_ratings(v1::LimitsScene& message,
                                                              const std::string& path, int n_a,
                                                              Problems& problems);

}  // namespace haptic::server
