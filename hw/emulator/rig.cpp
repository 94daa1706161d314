#include "hw/emulator/rig.hpp"

#include <cmath>
#include <utility>

namespace haptic::hw::emulator {
namespace {

/// The finger wears the linkage; what moves along with l_x beyond the cell is the rod's end.
FingerParameters finger_parameters() {
  FingerParameters p;
  p.actuator_mass = 0.02;
  p.actuator_damping = 0.5;
  p.actuator_friction = 0.0;
  return p;
}

}  // namespace

Rig::Rig(const ActuatorParameters& actuator, const SensorParameters& sensors, HandIntent intent,
         std::shared_ptr<const core::Kinematics> kinematics, std::uint64_t seed)
    : sensors_(sensors),
      intent_(std::move(intent)),
      finger_(finger_parameters(), std::move(kinematics), Eigen::Vector2d::Zero()),
      actuator_(actuator, finger_.q()[0]),
      noise_(seed) {}

void Rig::step() noexcept {
  ++steps_;
  actuator_.step(kStep, finger_.q()[0], finger_.l_dot());
  finger_.step(kStep, intent_.at(elapsed() - intent_since_), actuator_.force());
}

void Rig::take_to(const Eigen::Vector2d& target) {
  const core::VecQ from = held_ ? intent_.at(elapsed() - intent_since_) : core::VecQ(finger_.x());
  intent_ = HandIntent(from, target);
  intent_since_ = elapsed();
  held_ = true;
  finger_.hold(true);
}

void Rig::let_go() noexcept {
  held_ = false;
  finger_.hold(false);
}

Readings Rig::sense() noexcept {
  const auto read = [this](double value, double quantum, double rms) {
    return static_cast<float>(quantum * std::round((value + rms * noise_()) / quantum));
  };
  Readings readings;
  readings.q[0] = read(actuator_.x(), sensors_.quantum_l_x, sensors_.noise * sensors_.quantum_l_x);
  readings.q[1] = read(finger_.q()[1], sensors_.quantum_q_B, sensors_.noise * sensors_.quantum_q_B);
  readings.force[0] = read(actuator_.force(), sensors_.quantum_force, sensors_.noise_force);
  return readings;
}

}  // namespace haptic::hw::emulator
