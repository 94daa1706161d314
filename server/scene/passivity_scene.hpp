#pragma once
/// Energy tank and passivity observer of a device.

#include "haptic/core/passivity/passivity.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/scene/own_dynamics.hpp"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// Reads `message`, whose path is `path`, and fills in its defaults. `n_a` -1: not known, sizes are
/// not looked at. `own`: what stands in where the scene does not say.
[[nodiscard]] core::PassivitySettings read_passivity(v1::PassivityScene& message,
                                                     const std::string& path, int n_a,
                                                     const OwnDynamics& own, Problems& problems);

}  // namespace haptic::server
