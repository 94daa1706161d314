#pragma once
/// What a device is known to be by itself, without our force.

#include "server/scene/scene.hpp"

namespace haptic::server {

/// Per actuated DoF; empty where nothing is known, or where the device moves nothing (a recording).
struct OwnDynamics {
  core::VecA damping{};  ///< N s/m or N m s/rad
  core::VecA inertia{};  ///< kg or kg m^2
};

/// The hand's part is not counted: it may let go.
[[nodiscard]] OwnDynamics own_dynamics(const hw::DeviceConfig& source,
                                       const core::DofLayout& layout);

}  // namespace haptic::server
