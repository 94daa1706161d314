#pragma once
/// The parts of a scene. Each function reads the message of one part, whose path is `path` (such as
/// "device[0].impedance"), fills in the defaults of that message, and reports to `problems` what is
/// wrong. Used within server/scene only.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"
#include "server/scene/scene.hpp"

namespace haptic::server {

/// device.cpp. Relative files are relative to `folder`.
[[nodiscard]] DeviceScene read_device(v1::DeviceScene& message, const std::string& path,
                                      const std::filesystem::path& folder, Problems& problems);

/// source.cpp. Null if there is no source. `kinematics` null: it is wrong, sizes are not checked.
[[nodiscard]] std::shared_ptr<const hw::DeviceConfig> read_source(
    v1::DeviceScene& message, const std::string& path, const std::filesystem::path& folder,
    const core::Kinematics* kinematics, Problems& problems);

/// kinematics.cpp, mechanisms.cpp. Null if something is wrong.
using SharedKinematics = std::shared_ptr<const core::Kinematics>;
[[nodiscard]] SharedKinematics read_kinematics(v1::DeviceScene& message, const std::string& path,
                                               Problems& problems);
[[nodiscard]] SharedKinematics read_hand_exoskeleton(v1::HandExoskeletonScene& message,
                                                     const std::string& path, Problems& problems);
[[nodiscard]] SharedKinematics read_tracked_hand(v1::TrackedHandScene& message,
                                                 const std::string& path, Problems& problems);
[[nodiscard]] SharedKinematics read_stylus(v1::StylusScene& message, const std::string& path,
                                           Problems& problems);
[[nodiscard]] SharedKinematics read_serial_chain(v1::SerialChainScene& message,
                                                 const std::string& path, Problems& problems);
[[nodiscard]] core::FingerDimensions read_dimensions(v1::FingerExoskeletonScene& message,
                                                     const std::string& path, Problems& problems);
/// The result of `make`; null if it throws SceneError, which is reported at `path`.
[[nodiscard]] SharedKinematics made(const std::function<std::unique_ptr<core::Kinematics>()>& make,
                                    const std::string& path, Problems& problems);

/// rendering.cpp: metric, prior, impedance, force limits, staleness, renderer, guards. Needs
/// device.source and the kinematics.
void read_rendering(v1::DeviceScene& message, const std::string& path, DeviceScene& device,
                    Problems& problems);
/// Ages of a proxy or of a tracker's pose; returns fresh_end if the scene gives it.
[[nodiscard]] std::optional<core::Duration> read_staleness(v1::StalenessScene& message,
                                                           const std::string& path,
                                                           core::StalenessLimits& limits,
                                                           Problems& problems);

/// force_control.cpp. Needs device.source and the rendering.
void read_force_control(v1::ForceControlScene& message, const std::string& path,
                        DeviceScene& device, Problems& problems);

/// passivity.cpp. Needs device.source and the kinematics.
void read_passivity(v1::PassivityScene& message, const std::string& path, DeviceScene& device,
                    Problems& problems);
/// One sentence per actuated DoF whose stiffness is above 2 (b - B) / T: b is the device's own
/// damping, B the rendered one, T the loop's period. Source: Colgate and Schenkel,
/// b > K T / 2 + |B|; core/METHOD.md#sampled-data. None for a device of unknown dynamics.
[[nodiscard]] std::vector<std::string> passivity_warnings(const Scene& scene);

/// daemon.cpp.
[[nodiscard]] ServerScene read_server(v1::ServerScene& message, const std::filesystem::path& folder,
                                      Problems& problems);
/// `devices`: of the scene. They decide the defaults on lateness, and get late_bucket_full.
[[nodiscard]] LoopScene read_loop(v1::LoopScene& message, std::vector<DeviceScene>& devices,
                                  Problems& problems);
[[nodiscard]] RecordScene read_record(v1::RecordScene& message, Problems& problems);

/// Number of actuated DoFs; -1: not known, because the kinematics is wrong.
[[nodiscard]] inline int n_a_of(const core::Kinematics* kinematics) {
  return kinematics == nullptr ? -1 : kinematics->layout().n_a();
}

}  // namespace haptic::server
