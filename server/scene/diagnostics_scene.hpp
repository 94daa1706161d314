#pragma once
/// What a device's scene has its states say beside the device's own: the passivity certificate and the
/// coupling metric.

#include <optional>

#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// Reports it beside a prior, with which it is not defined.
[[nodiscard]] bool read_passivity_certificate(const v1::DeviceScene& message,
                                              const std::string& path, Problems& problems);
/// The softness, its default filled in; empty where the scene has no coupling metric.
[[nodiscard]] std::optional<double> read_coupling_metric(v1::DeviceScene& message,
                                                         const std::string& path,
                                                         Problems& problems);

}  // namespace haptic::server
