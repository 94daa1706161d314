#include "server/scene/device_scene.hpp"

#include "haptic/core/error.hpp"
#include "server/scene/diagnostics_scene.hpp"
#include "server/scene/force_control_scene.hpp"
#include "server/scene/kinematics_scene.hpp"
#include "server/scene/passivity_scene.hpp"
#include "server/scene/projection_scene.hpp"
#include "server/scene/ratings_scene.hpp"
#include "server/scene/render_scene.hpp"
#include "server/scene/source_scene.hpp"
#include "server/scene/tracker_scene.hpp"

namespace haptic::server {
namespace {

/// Device names travel in requests, log lines and health entries.
void check_name(const std::string& name, const std::string& path, Problems& problems) {
  const bool well_formed =
      !name.empty() && name.size() <= 32 &&
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_-") == std::string::npos;
  if (!well_formed) problems.wrong(path + ".name", quoted(name), "must be 1 to 32 of [a-z0-9_-]");
}

SharedKinematics read_kinematics(v1::DeviceScene& message, const std::string& path,
                                 Problems& problems) {
  switch (message.kinematics_case()) {
    case v1::DeviceScene::kFingerExoskeleton:
      return read_finger_exoskeleton(*message.mutable_finger_exoskeleton(),
                                     path + ".finger_exoskeleton", problems);
    case v1::DeviceScene::kLinear:
      return read_linear(*message.mutable_linear(), path + ".linear", problems);
    case v1::DeviceScene::kHandExoskeleton:
      return read_hand_exoskeleton(*message.mutable_hand_exoskeleton(), path + ".hand_exoskeleton",
                                   problems);
    case v1::DeviceScene::kTrackedHand:
      return read_tracked_hand(*message.mutable_tracked_hand(), path + ".tracked_hand", problems);
    case v1::DeviceScene::kStylus:
      return read_stylus(*message.mutable_stylus(), path + ".stylus", problems);
    case v1::DeviceScene::kSerialChain:
      return read_serial_chain(*message.mutable_serial_chain(), path + ".serial_chain", problems);
    case v1::DeviceScene::KINEMATICS_NOT_SET:
      break;
  }
  problems.missing(
      path + ".kinematics",
      "one of finger_exoskeleton, linear, hand_exoskeleton, tracked_hand, stylus, serial_chain");
  return nullptr;
}

/// Z_q couples DoFs of one device: fingers are devices of their own.
void couple(const std::shared_ptr<const core::StiffnessCoupling>& coupling, const std::string& path,
            DeviceScene& device, Problems& problems) {
  if (!coupling || !device.kinematics) return;
  device.projection.coupling = coupling;
  try {
    core::check_coupling(*device.kinematics, *coupling);
  } catch (const core::SceneError& error) {
    problems.wrong(path + ".impedance.stiffness_matrix", "{ not diagonal }", error.what());
  }
}

/// Of a board that has one; else null.
const hw::board::Calibration* calibration_of(const hw::DeviceConfig& source) {
  const auto* const board = std::get_if<hw::BoardConfig>(&source);
  return board != nullptr && board->calibration ? &*board->calibration : nullptr;
}

}  // namespace

DeviceScene read_device(v1::DeviceScene& message, const std::string& path,
                        const std::filesystem::path& folder, Problems& problems) {
  check_name(message.name(), path, problems);
  DeviceScene device;
  device.name = message.name();
  device.kinematics = read_kinematics(message, path, problems);
  device.projection = read_projection(message, path, device.kinematics.get(), problems);
  const core::DofLayout* layout = device.kinematics ? &device.kinematics->layout() : nullptr;
  const Source source = read_source(message, path, folder, device.kinematics.get(), problems);
  device.source = source.config;
  RenderScene render = read_render(message, path, layout == nullptr ? -1 : layout->n_a(),
                                   source.max_effort, problems);
  device.settings = std::move(render.settings);
  couple(render.coupling, path, device, problems);
  device.fresh_end = render.fresh_end;
  device.monotone_envelope = message.has_monotone_envelope();
  device.passivity_certificate = read_passivity_certificate(message, path, problems);
  device.coupling_softness = read_coupling_metric(message, path, problems);
  if (message.has_limits()) {
    device.ratings = read_ratings(*message.mutable_limits(), path + ".limits",
                                  layout == nullptr ? -1 : layout->n_a(), problems);
  }
  if (message.has_tracker()) {
    const auto tracker = read_tracker(*message.mutable_tracker(), path + ".tracker",
                                      device.kinematics.get(), problems);
    if (tracker) {
      device.tracker = tracker->settings;
      device.tracker_fresh_end = tracker->fresh_end;
    }
  }
  if (message.has_force_control()) {
    device.force_control =
        read_force_control(message, path, device.kinematics.get(), calibration_of(device.source),
                           device.settings.force_limit, source.max_effort, problems);
  }
  if (message.has_passivity()) {
    const OwnDynamics own =
        layout == nullptr ? OwnDynamics{} : own_dynamics(source.config, *layout);
    device.passivity = read_passivity(*message.mutable_passivity(), path + ".passivity",
                                      layout == nullptr ? -1 : layout->n_a(), own, problems);
  }
  return device;
}

core::PipelineConfig pipeline_config(const DeviceScene& scene, const core::DeviceLimits& limits) {
  core::PipelineConfig config;
  config.kinematics = scene.kinematics;
  config.projection = scene.projection;
  config.device = limits;
  config.scene = scene.settings;
  config.monotone_envelope = scene.monotone_envelope;
  config.passivity_certificate = scene.passivity_certificate;
  config.passivity = scene.passivity;
  config.ratings = scene.ratings;
  config.force_control = scene.force_control.settings;
  config.tracker = scene.tracker;
  return config;
}

}  // namespace haptic::server
