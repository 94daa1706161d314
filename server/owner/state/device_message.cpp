#include "server/owner/state/device_message.hpp"

#include "server/owner/state/drawing_message.hpp"

namespace haptic::server {
namespace {

void copy(const core::VecA& from, google::protobuf::RepeatedField<double>* to) {
  to->Add(from.data(), from.data() + from.size());
}

const char* unit_name(core::Unit unit) {
  return unit == core::Unit::kMetre ? "m" : "rad";
}

const char* kind_name(core::CoordinateKind kind) {
  if (kind == core::CoordinateKind::kAngle) return "angle";
  return kind == core::CoordinateKind::kQuaternion ? "quaternion" : "linear";
}

}  // namespace

v1::Device describe(const std::string& name, const hw::DeviceInfo& info,
                    const core::PipelineConfig& config) {
  v1::Device message;
  message.set_name(name);
  message.set_kind(info.kind);
  message.set_model(info.model);
  message.set_serial(info.serial);
  message.set_moves(info.moves);
  message.set_calibrated(info.calibrated);
  message.set_measures_force(info.measures_force);
  Eigen::Index actuated = 0;
  for (const core::DofSpec& spec : info.dofs) {
    auto* dof = message.add_dofs();
    dof->set_name(spec.name);
    dof->set_unit(unit_name(spec.unit));
    dof->set_actuated(spec.actuated);
    dof->set_lower(spec.lower);
    dof->set_upper(spec.upper);
    if (!spec.actuated) continue;
    if (actuated < config.device.max_effort.size()) {
      dof->set_max_effort(config.device.max_effort[actuated]);
    }
    ++actuated;
  }
  for (const core::Coordinate& coordinate : config.kinematics->space().coordinates()) {
    auto* entry = message.add_coordinates();
    entry->set_name(coordinate.name);
    const bool quaternion = coordinate.kind == core::CoordinateKind::kQuaternion;
    entry->set_unit(quaternion ? "1" : unit_name(coordinate.unit));
    entry->set_kind(kind_name(coordinate.kind));
  }
  copy(config.scene.stiffness, message.mutable_stiffness_limit());
  copy(config.scene.damping, message.mutable_damping_limit());
  copy(config.scene.force_limit, message.mutable_force_limit());
  copy(config.scene.slew_limit, message.mutable_slew_limit());
  copy(config.scene.engage_window, message.mutable_engage_window());
  const core::Drawing drawing = config.kinematics->drawing();
  if (!drawing.bodies.empty()) *message.mutable_drawing() = to_message(drawing);
  message.set_wants_tracker(config.tracker.has_value());
  if (!config.scene.direction_guard) message.add_unguarded("direction_guard");
  if (!config.passivity.tank.enabled) message.add_unguarded("energy_tank");
  return message;
}

}  // namespace haptic::server
