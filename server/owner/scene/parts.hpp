#pragma once
/// The parts of a scene. Each function reads the message of one part, fills in the defaults of that
/// message, and reports what is wrong. Used within server/owner/scene only.

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/owner/scene/reader.hpp"
#include "server/owner/scene/scene.hpp"

namespace haptic::server {

/// device.cpp.
[[nodiscard]] DeviceScene read_device(const Part<v1::DeviceScene>& part);

/// source.cpp. Null if there is no source. `kinematics` null: it is wrong, sizes are not checked.
[[nodiscard]] std::shared_ptr<const hw::DeviceConfig> read_source(
    const Part<v1::DeviceScene>& part, const core::Kinematics* kinematics);
/// source.cpp. What a scene does not say depends on the source.
[[nodiscard]] core::SensorFilter read_filter(const Part<v1::DeviceScene>& part);

/// kinematics.cpp, mechanisms.cpp. Null if something is wrong.
using SharedKinematics = std::shared_ptr<const core::Kinematics>;
[[nodiscard]] SharedKinematics read_kinematics(const Part<v1::DeviceScene>& part);
[[nodiscard]] SharedKinematics read_hand_exoskeleton(const Part<v1::HandExoskeletonScene>& part);
[[nodiscard]] SharedKinematics read_tracked_hand(const Part<v1::TrackedHandScene>& part);
[[nodiscard]] SharedKinematics read_stylus(const Part<v1::StylusScene>& part);
[[nodiscard]] SharedKinematics read_serial_chain(const Part<v1::SerialChainScene>& part);
[[nodiscard]] core::FingerDimensions read_dimensions(const Part<v1::FingerExoskeletonScene>& part);

/// The result of `make`; null if the message has errors, or the mechanism is impossible.
template <typename Make>
[[nodiscard]] SharedKinematics made(const Fields& part, const Make& make) {
  if (!part.good()) return nullptr;
  return part.attempt("", "{ ... }", [&] { return SharedKinematics(make()); });
}

/// rendering.cpp: metric, prior, impedance, force limits, staleness, renderer, guards. Needs
/// device.source and the kinematics.
void read_rendering(const Part<v1::DeviceScene>& part, DeviceScene& device);
/// Ages of a proxy or of a tracker's pose; returns fresh_end if the scene gives it.
[[nodiscard]] std::optional<core::Duration> read_staleness(const Part<v1::StalenessScene>& part,
                                                           core::StalenessLimits& limits);

/// force_control.cpp. Needs device.source and the rendering.
void read_force_control(const Part<v1::ForceControlScene>& part, DeviceScene& device);

/// safeguards.cpp. The guard, and, once the rendering is read, the tank of a device that neither
/// names them nor says `unguarded`.
void add_guard(const Part<v1::DeviceScene>& part);
void add_tank(const Part<v1::DeviceScene>& part, const core::PipelineConfig& device);
/// One sentence per guard and tank that `unguarded` leaves out.
[[nodiscard]] std::vector<std::string> safeguard_warnings(const Scene& scene);

/// passivity.cpp. Needs device.source and the kinematics.
void read_passivity(const Part<v1::PassivityScene>& part, DeviceScene& device);
/// One sentence per actuated DoF whose stiffness is above 2 (b - B) / T: b is the device's own
/// damping, B the rendered one, T the loop's period. Source: Colgate and Schenkel,
/// b > K T / 2 + |B|; core/METHOD.md#sampled-data. None for a device of unknown dynamics.
[[nodiscard]] std::vector<std::string> passivity_warnings(const Scene& scene);

/// daemon.cpp.
[[nodiscard]] ServerScene read_server(const Part<v1::ServerScene>& part);
/// web.cpp. `addresses`: those that are taken; they grow.
[[nodiscard]] WebConfig read_web(const Part<v1::WebScene>& part, std::set<std::string>& addresses);
/// `listen` of a part, whose addresses are to be others than those in `taken`; they join it.
[[nodiscard]] std::vector<std::string> read_addresses(
    const Fields& part, const google::protobuf::RepeatedPtrField<std::string>& listen,
    std::set<std::string>& taken);
/// `devices`: of the scene. They decide the defaults on lateness, and get late_bucket_full.
[[nodiscard]] LoopScene read_loop(const Part<v1::LoopScene>& part,
                                  std::vector<DeviceScene>& devices);
[[nodiscard]] RecordScene read_record(const Part<v1::RecordScene>& part);

/// Number of actuated DoFs; -1: not known, because the kinematics is wrong.
[[nodiscard]] inline int n_a_of(const DeviceScene& device) {
  const core::Kinematics* const kinematics = device.pipeline.kinematics.get();
  return kinematics == nullptr ? -1 : kinematics->layout().n_a();
}
/// Largest force of the device per actuated DoF; empty if the source is wrong.
[[nodiscard]] inline core::VecA effort_of(const DeviceScene& device) {
  return device.source ? device.source->effort() : core::VecA{};
}
/// Reports each of `forces`, the values of `field`, that is above what the device can give.
inline void check_within_effort(const Fields& part, const char* field, const core::VecA& forces,
                                const core::VecA& effort) {
  for (Eigen::Index i = 0; i < std::min(forces.size(), effort.size()); ++i) {
    if (forces[i] <= effort[i]) continue;
    part.wrong({field, static_cast<std::size_t>(i)}, decimal(forces[i]),
               "must be at most what the device can give, " + decimal(effort[i]));
  }
}

}  // namespace haptic::server
