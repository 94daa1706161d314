#include "hw/simulated/finger.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"
#include "hw/device_limits.hpp"

namespace haptic::hw {
namespace {

/// The pose in which the simulation begins: the finger straight, x = 0.
const Eigen::Vector2d kRest = Eigen::Vector2d::Zero();

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

}  // namespace

std::unique_ptr<Device> SimulatedFingerConfig::open(
    std::shared_ptr<const core::Kinematics> kinematics, core::Duration) const {
  return std::make_unique<SimulatedFinger>(*this, kinematics);
}

core::VecA SimulatedFingerConfig::effort() const {
  return core::VecA::Constant(1, actuator_force_limit);
}

OwnDynamics SimulatedFingerConfig::own_dynamics(const core::DofLayout&) const {
  return {core::VecA::Constant(1, finger.actuator_damping),
          core::VecA::Constant(1, finger.actuator_mass)};
}

SimulatedFinger::SimulatedFinger(const SimulatedFingerConfig& config,
                                 const std::shared_ptr<const core::Kinematics>& kinematics)
    : config_(config),
      info_(describe(config, *require_finger(kinematics))),
      intent_(intent_of(config)),
      physics_(config.finger, kinematics, kRest),
      noise_(config.seed) {}

void SimulatedFinger::read(core::TimePoint now, core::DeviceReading& reading) noexcept {
  if (!book_.begin_read(now, reading)) return;
  for (int n = substeps_.advance(now); n > 0; --n) {
    ++steps_;
    physics_.step(Substeps::kStepSeconds,
                  intent_.at(static_cast<double>(steps_) * Substeps::kStepSeconds), tau_a_);
  }
  // The part of a step up to `now` at constant velocity: a rate taken from samples and their times
  // must not see the step's grid.
  core::VecQ q = physics_.q_ahead(core::seconds(substeps_.rest()));
  config_.measure(q, 0, noise_);
  book_.deliver(now, q, reading);
}

void SimulatedFinger::write(core::TimePoint, const Command& command) noexcept {
  const bool follows =
      book_.follows(command) && command.tau_a.size() == 1 && std::isfinite(command.tau_a[0]);
  const double limit = config_.actuator_force_limit;
  tau_a_ = follows ? std::clamp(command.tau_a[0], -limit, limit) : 0.0;
}

void SimulatedFinger::close() noexcept {
  book_.close();
  tau_a_ = 0.0;
}

}  // namespace haptic::hw
