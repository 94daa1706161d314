#pragma once
/// The map of a device: f : Q -> X from its message.

#include <functional>
#include <memory>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"

namespace haptic::server {

using SharedKinematics = std::shared_ptr<const core::Kinematics>;

/// Each fills in the defaults of its message, whose path is `path`; null where
/// something is wrong, which went to `problems`.
[[nodiscard]] SharedKinematics read_finger_exoskeleton(v1::FingerExoskeletonScene& message,
                                                       const std::string& path, Problems& problems);
[[nodiscard]] SharedKinematics read_linear(v1::LinearScene& message, const std::string& path,
                                           Problems& problems);
[[nodiscard]] SharedKinematics read_hand_exoskeleton(v1::HandExoskeletonScene& message,
                                                     const std::string& path, Problems& problems);
[[nodiscard]] SharedKinematics read_tracked_hand(v1::TrackedHandScene& message,
                                                 const std::string& path, Problems& problems);
[[nodiscard]] SharedKinematics read_stylus(v1::StylusScene& message, const std::string& path,
                                           Problems& problems);
[[nodiscard]] SharedKinematics read_serial_chain(v1::SerialChainScene& message,
                                                 const std::string& path, Problems& problems);

/// What `make` makes; null where it throws SceneError, which goes to `problems`.
[[nodiscard]] SharedKinematics made(const std::function<std::unique_ptr<core::Kinematics>()>& make,
                                    const std::string& path, Problems& problems);

}  // namespace haptic::server
