#pragma once
/// Surroundings of an emulated board: actuator, load cell, an exoskeleton on a simulated finger,
/// and sensors with noise and resolution. The same seed gives the same bits.

#include <cstdint>
#include <memory>

#include "haptic/core/model/kinematics.hpp"
#include "hw/emulator/linear_actuator.hpp"
#include "hw/random.hpp"
#include "hw/simulated/finger_physics.hpp"
#include "hw/simulated/hand_intent.hpp"

namespace haptic::hw::emulator {

struct SensorParameters {
  // 12-bit converters: the 50 mm potentiometer of the L16, and one of 270 degrees at q_B.
  double quantum_l_x{0.050 / 4096}, quantum_q_B{4.712389 / 4096};  ///< m, rad
  double noise{1.0};                                               ///< rms of both, in quanta
  double quantum_force{0.003};                                     ///< N: 16 bits over +-100 N
  double noise_force{0.03};                                        ///< N rms
};

struct Readings {
  float q[2]{};      ///< (l_x, q_B)
  float force[1]{};  ///< N in the load cell, positive pushes towards larger l_x
};

class Rig {
 public:
  static constexpr int kStepUs = 100;             ///< of the physics, us
  static constexpr double kStep = kStepUs / 1e6;  ///< the same, s

  Rig(const ActuatorParameters& actuator, const SensorParameters& sensors, HandIntent intent,
      std::shared_ptr<const core::Kinematics> kinematics, std::uint64_t seed);

  void step() noexcept;  ///< kStep s
  [[nodiscard]] Readings sense() noexcept;

  /// The hand takes the finger (if it had let go) and brings it to `target` (rad, MCP and PIP)
  /// within Course::kRise, starting at its present target.
  void take_to(const Eigen::Vector2d& target);
  /// The hand hangs loose and pushes no longer against the device.
  void let_go() noexcept;

  [[nodiscard]] LinearActuator& actuator() noexcept { return actuator_; }
  [[nodiscard]] const LinearActuator& actuator() const noexcept { return actuator_; }
  [[nodiscard]] const FingerPhysics& finger() const noexcept { return finger_; }
  [[nodiscard]] double elapsed() const noexcept { return static_cast<double>(steps_) * kStep; }

 private:
  SensorParameters sensors_;
  HandIntent intent_;         ///< MCP and PIP, rad
  double intent_since_{0.0};  ///< s
  bool held_{true};
  FingerPhysics finger_;
  LinearActuator actuator_;
  Gaussian noise_;
  std::uint64_t steps_{0};
};

}  // namespace haptic::hw::emulator
