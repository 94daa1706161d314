#pragma once
/// One device of a scene: defaults into its message, checks, and the struct that comes of it.

#include <filesystem>

#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"
#include "server/scene/scene.hpp"

namespace haptic::server {

/// Fills in every default of `message` and reads it; what is wrong goes to `problems`. `path` is
/// the message's, "device[0]"; relative files are relative to `folder`.
[[nodiscard]] DeviceScene read_device(v1::DeviceScene& message, const std::string& path,
                                      const std::filesystem::path& folder, Problems& problems);

/// The kinematics of a device; null where something is wrong with them.
[[nodiscard]] std::shared_ptr<const core::Kinematics> read_kinematics(v1::DeviceScene& message,
                                                                      const std::string& path,
                                                                      Problems& problems);

/// A positive or zero duration; `fallback` where the field is absent, and set in the message.
[[nodiscard]] core::Duration read_duration(google::protobuf::Duration& field, bool present,
                                           core::Duration fallback);

/// One value per entry of `field`, each checked: finite and > (or >=) lowest.
[[nodiscard]] core::VecX read_list(const google::protobuf::RepeatedField<double>& field, int wanted,
                                   const std::string& path, const std::string& per, double lowest,
                                   bool lowest_allowed, Problems& problems);

}  // namespace haptic::server
