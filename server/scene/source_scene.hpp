#pragma once
/// Where a device's motion comes from, and what it can give.

#include <filesystem>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/v1/scene.pb.h"
#include "hw/open_device.hpp"
#include "server/scene/problems.hpp"

namespace haptic::server {

struct Source {
  hw::DeviceConfig config{};
  core::VecA max_effort{};  ///< n_a, N or N m; empty where it is wrong
};

/// Reads the source of a device whose path is `path`, and fills in its
/// defaults; relative files are relative to `folder`. `kinematics` null: it
/// is wrong, so sizes are not looked at.
[[nodiscard]] Source read_source(v1::DeviceScene& message, const std::string& path,
                                 const std::filesystem::path& folder,
                                 const core::Kinematics* kinematics, Problems& problems);

}  // namespace haptic::server
