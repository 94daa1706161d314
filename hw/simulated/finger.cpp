#include "hw/simulated/finger.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"
#include "hw/device_limits.hpp"

namespace haptic::hw {
namespace {

/// The pose in which the simulation begins: the finger straight, x = 0.
const Eigen::Vector2d kRest = Eigen::Vector2d::Zero();

void check(const SimulatedFingerConfig& c) {
  require_finite("target_mcp_rad", c.target_mcp);
  require_finite("target_pip_rad", c.target_pip);
  require_positive("hand_stiffness", c.hand_stiffness);
  require_not_negative("hand_damping", c.hand_damping);
  require_positive("inertia_mcp", c.inertia_mcp);
  require_positive("inertia_pip", c.inertia_pip);
  require_positive("actuator_mass_kg", c.actuator_mass);
  require_not_negative("actuator_damping", c.actuator_damping);
  require_not_negative("actuator_friction_n", c.actuator_friction);
  require_positive("actuator_force_limit_n", c.actuator_force_limit);
  require_not_negative("noise_l_x_m", c.noise_l_x);
  require_not_negative("noise_q_B_rad", c.noise_q_B);
  require_not_negative("resolution_l_x_m", c.resolution_l_x);
  require_not_negative("resolution_q_B_rad", c.resolution_q_B);
}

std::shared_ptr<const core::Kinematics> require_finger(
    std::shared_ptr<const core::Kinematics> kinematics) {
  const bool shapes = kinematics->layout().n_q() == 2 && kinematics->layout().n_a() == 1 &&
                      kinematics->space().n_x() == 2;
  core::VecQ q = core::VecQ::Zero(2);
  const core::VecX x = core::VecX::Zero(2);
  if (!shapes || kinematics->inverse(x, q) == core::InverseStatus::kNotOffered) {
    throw core::DeviceError("simulated_finger: the kinematics has " +
                            std::to_string(kinematics->layout().n_q()) + " DoF(s), " +
                            std::to_string(kinematics->layout().n_a()) + " actuated, and " +
                            std::to_string(kinematics->space().n_x()) +
                            " coordinate(s); must be finger_exoskeleton (l_x actuated, q_B sensed, "
                            "two joints, inverse)");
  }
  return kinematics;
}

FingerParameters parameters(const SimulatedFingerConfig& c) {
  FingerParameters p;
  p.inertia = {c.inertia_mcp, c.inertia_pip};
  p.hand_stiffness = c.hand_stiffness;
  p.hand_damping = c.hand_damping;
  p.actuator_mass = c.actuator_mass;
  p.actuator_damping = c.actuator_damping;
  p.actuator_friction = c.actuator_friction;
  return p;
}

Intent intent_of(const SimulatedFingerConfig& c) {
  if (!c.motion_file.empty()) return {kRest, c.motion_file};
  return {kRest, Eigen::Vector2d(c.target_mcp, c.target_pip)};
}

DeviceInfo describe(const SimulatedFingerConfig& c, const core::Kinematics& kinematics) {
  DeviceInfo info;
  info.kind = "simulated";
  info.model = "finger exoskeleton worn on a simulated finger";
  info.model += c.motion_file.empty() ? ", constant target"
                                      : " that follows " + c.motion_file.filename().string();
  info.dofs = kinematics.dofs();
  info.limits = device_limits(kinematics, c.effort());
  return info;
}

double quantised(double value, double quantum) {
  return quantum > 0.0 ? quantum * std::round(value / quantum) : value;
}

}  // namespace

std::unique_ptr<Device> SimulatedFingerConfig::open(
    std::shared_ptr<const core::Kinematics> kinematics, core::Duration) const {
  return std::make_unique<SimulatedFinger>(*this, std::move(kinematics));
}

core::VecA SimulatedFingerConfig::effort() const {
  return core::VecA::Constant(1, actuator_force_limit);
}

OwnDynamics SimulatedFingerConfig::own_dynamics(const core::DofLayout&) const {
  return {core::VecA::Constant(1, actuator_damping), core::VecA::Constant(1, actuator_mass)};
}

SimulatedFinger::SimulatedFinger(const SimulatedFingerConfig& config,
                                 std::shared_ptr<const core::Kinematics> kinematics)
    : config_((check(config), config)),
      info_(describe(config, *require_finger(kinematics))),
      intent_(intent_of(config)),
      physics_(parameters(config), std::move(kinematics), kRest),
      noise_(config.seed) {}

double SimulatedFinger::elapsed() const noexcept {
  return static_cast<double>(steps_) * Substeps::kStepSeconds + core::seconds(substeps_.rest());
}

core::VecQ SimulatedFinger::measured(core::VecQ q) noexcept {
  // Both numbers are drawn in every sample, so that one sensor's noise does not depend on the
  // other's.
  const double noise_l_x = config_.noise_l_x * noise_();
  const double noise_q_B = config_.noise_q_B * noise_();
  q[0] = quantised(q[0] + noise_l_x, config_.resolution_l_x);
  q[1] = quantised(q[1] + noise_q_B, config_.resolution_q_B);
  return q;
}

void SimulatedFinger::read(core::TimePoint now, core::DeviceReading& reading) noexcept {
  reading.fresh = false;
  if (closed_) {
    reading.armed = false;
    reading.health = core::DeviceHealth::kLost;
    return;
  }
  for (int n = substeps_.advance(now); n > 0; --n) {
    ++steps_;
    physics_.step(Substeps::kStepSeconds,
                  intent_.at(static_cast<double>(steps_) * Substeps::kStepSeconds), tau_a_);
  }
  arming_.on_read();
  reading.armed = arming_.armed();
  reading.health = core::DeviceHealth::kOk;
  if (now <= last_read_) return;  // time stands still: there is nothing new to measure
  last_read_ = now;
  reading.fresh = true;
  reading.sample.seq = ++seq_;
  reading.sample.time = now;
  // The part of a step up to `now` at constant velocity: a rate taken from samples and their times
  // must not see the step's grid.
  reading.sample.q = measured(physics_.q_ahead(core::seconds(substeps_.rest())));
  reading.sample.tau_measured.resize(0);
}

void SimulatedFinger::write(core::TimePoint, const Command& command) noexcept {
  arming_.on_write(command.arm && !closed_);
  const bool follows =
      arming_.armed() && command.tau_a.size() == 1 && std::isfinite(command.tau_a[0]);
  const double limit = config_.actuator_force_limit;
  tau_a_ = follows ? std::clamp(command.tau_a[0], -limit, limit) : 0.0;
}

void SimulatedFinger::close() noexcept {
  closed_ = true;
  arming_.disarm();
  tau_a_ = 0.0;
}

}  // namespace haptic::hw
