#pragma once
/// One device of a scene, from its message.

#include <filesystem>

#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"
#include "server/scene/scene.hpp"

namespace haptic::server {

/// Reads the device and fills in every default of its message; what is wrong
/// goes to `problems`. `path` is the message's, "device[0]"; relative files are
/// relative to `folder`.
[[nodiscard]] DeviceScene read_device(v1::DeviceScene& message, const std::string& path,
                                      const std::filesystem::path& folder, Problems& problems);

}  // namespace haptic::server
