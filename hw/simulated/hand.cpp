#include "hw/simulated/hand.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"
#include "hw/device_limits.hpp"
#include "hw/replay/tracked_orientation.hpp"

namespace haptic::hw {
namespace {

constexpr int kPalmDofs = 6;

/// Throws DeviceError unless q is a hand's: a palm or none, then (NAME.l_x, NAME.q_B) of each
/// finger; or (l_x, q_B) of one alone.
HandLayout layout_of(const core::Kinematics& kinematics) {
  constexpr std::string_view kActuator = "l_x";
  HandLayout layout;
  int n_q = 0;
  if (const auto rotation = rotation_vector_in(kinematics.dofs())) {
    layout.palm = static_cast<Eigen::Index>(*rotation) - 3;
    n_q += kPalmDofs;
  }
  for (const core::Mechanism& finger : kinematics.mechanisms()) {
    const std::string& name = kinematics.dofs()[static_cast<std::size_t>(finger.first_q)].name;
    if (!name.ends_with(kActuator)) continue;
    layout.fingers.push_back({name.substr(0, name.size() - kActuator.size()), finger.first_q});
    n_q += 2;
  }
  if (layout.fingers.empty() || n_q != kinematics.layout().n_q()) {
    throw core::DeviceError(
        "simulated hand: the kinematics has " + std::to_string(kinematics.layout().n_q()) +
        " DoF(s), " + std::to_string(layout.fingers.size()) +
        " finger(s); must be finger_exoskeleton, hand_exoskeleton or tracked_hand");
  }
  return layout;
}

SimulatedHandConfig with_target(SimulatedHandConfig c, Eigen::Index n_q) {
  if (c.target.size() == 0) c.target.setZero(n_q);
  return c;
}

void check_sizes(const SimulatedHandConfig& c, const HandLayout& layout, Eigen::Index n_q) {
  const auto wrong = [](const char* what, Eigen::Index is, Eigen::Index must) {
    throw core::DeviceError(std::string("simulated hand: ") + what + " = " + std::to_string(is) +
                            ": must be the kinematics', " + std::to_string(must));
  };
  const auto fingers = static_cast<Eigen::Index>(layout.fingers.size());
  if (c.fingers != fingers) wrong("number of fingers", c.fingers, fingers);
  if (c.target.size() != n_q) wrong("size of target", c.target.size(), n_q);
}

HandIntent intent_of(const SimulatedHandConfig& c, const HandLayout& layout,
                     const core::Kinematics& kinematics) {
  check_sizes(c, layout, kinematics.layout().n_q());
  if (c.motion_file.empty()) return HandIntent(layout, c.target);
  return {layout, c.target, kinematics, c.motion_file};
}

DeviceInfo describe(const SimulatedHandConfig& c, const HandIntent& intent,
                    const core::Kinematics& kinematics) {
  DeviceInfo info;
  info.kind = "simulated";
  info.model = "exoskeleton worn on ";
  info.model += c.fingers == 1 ? "a simulated finger" : "a simulated hand";
  if (c.motion_file.empty()) {
    info.model += ", constant target";
  } else {
    info.model += c.fingers == 1 ? " that follows "
                                 : ", " + std::to_string(intent.recorded_fingers()) + " of " +
                                       std::to_string(c.fingers) + " fingers follow ";
    info.model += c.motion_file.filename().string();
  }
  info.notes = intent.doubts();
  info.dofs = kinematics.dofs();
  info.limits = device_limits(kinematics, c.effort());
  return info;
}

}  // namespace

std::unique_ptr<Device> SimulatedHandConfig::open(
    std::shared_ptr<const core::Kinematics> kinematics, core::Duration) const {
  return std::make_unique<SimulatedHand>(*this, std::move(kinematics));
}

core::VecA SimulatedHandConfig::effort() const {
  return core::VecA::Constant(fingers, actuator_force_limit);
}

OwnDynamics SimulatedHandConfig::own_dynamics(const core::DofLayout& layout) const {
  return {core::VecA::Constant(layout.n_a(), finger.actuator_damping),
          core::VecA::Constant(layout.n_a(), finger.actuator_mass)};
}

SimulatedHand::SimulatedHand(const SimulatedHandConfig& config,
                             std::shared_ptr<const core::Kinematics> kinematics)
    : config_(with_target(config, kinematics->layout().n_q())),
      layout_(layout_of(*kinematics)),
      intent_(intent_of(config_, layout_, *kinematics)),
      noise_(config.seed),
      step_(kinematics->layout().n_q() == 2 ? Substeps::kStep : kStep),
      aim_(config_.target) {
  info_ = describe(config, intent_, *kinematics);
  for (const core::Mechanism& finger : kinematics->mechanisms()) {
    // Shares the ownership of the whole map.
    const std::shared_ptr<const core::Kinematics> map(kinematics, finger.kinematics);
    fingers_.emplace_back(config.finger, map, Eigen::Vector2d::Zero());
  }
  if (layout_.palm) {
    const core::DofSpec& x = kinematics->dofs()[static_cast<std::size_t>(*layout_.palm)];
    aim_ = intent_.at(0.0);
    palm_.emplace(config.arm, aimed_palm(), x.lower, x.upper);
  }
  tau_a_ = core::VecA::Zero(config.fingers);
}

PalmPose SimulatedHand::aimed_palm() const noexcept {
  return {aim_.segment<3>(*layout_.palm), aim_.segment<3>(*layout_.palm + 3)};
}

void SimulatedHand::step() noexcept {
  const double dt = core::seconds(step_);
  aim_ = intent_.at(static_cast<double>(++steps_) * dt);
  for (std::size_t i = 0; i < fingers_.size(); ++i) {
    fingers_[i].step(dt, aim_.segment<2>(layout_.fingers[i].first),
                     tau_a_[static_cast<Eigen::Index>(i)]);
  }
  if (palm_) palm_->step(dt, aimed_palm());
}

void SimulatedHand::read(core::TimePoint now, core::DeviceReading& reading) noexcept {
  if (!book_.begin_read(now, reading)) return;
  for (int n = substeps_.advance(now); n > 0; --n) step();
  // The part of a step up to `now` at constant velocity: a rate taken from samples and their times
  // must not see the step's grid.
  const double ahead = core::seconds(substeps_.rest());
  core::VecQ q(config_.target.size());
  if (palm_) {
    const PalmPose pose = palm_->ahead(ahead);
    q.segment<3>(*layout_.palm) = pose.position;
    q.segment<3>(*layout_.palm + 3) = pose.rotation;
  }
  for (std::size_t i = 0; i < fingers_.size(); ++i) {
    const Eigen::Index first = layout_.fingers[i].first;
    q.segment<2>(first) = fingers_[i].q_ahead(ahead);
    config_.measure(q, first, noise_);
  }
  book_.deliver(now, q, reading);
}

void SimulatedHand::write(core::TimePoint, const Command& command) noexcept {
  tau_a_.setZero();
  if (!book_.follows(command) || command.tau_a.size() != tau_a_.size()) return;
  const double limit = config_.actuator_force_limit;
  for (Eigen::Index i = 0; i < tau_a_.size(); ++i) {
    const double tau = command.tau_a[i];
    tau_a_[i] = std::isfinite(tau) ? std::clamp(tau, -limit, limit) : 0.0;
  }
}

void SimulatedHand::close() noexcept {
  book_.close();
  tau_a_.setZero();
}

}  // namespace haptic::hw
