#include "haptic/core/model/stylus.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "haptic/core/error.hpp"

namespace haptic::core {

namespace {

void require_length(double value, const char* name) {
  require(value > 0.0, std::string("stylus.") + name, value, "> 0");
}

Pose3 along_x(double x) {
  return {{x, 0.0, 0.0}, {}};
}

}  // namespace

SerialChainParameters stylus_chain(const StylusDimensions& d) {
  require_length(d.upper_arm, "upper_arm_m");
  require_length(d.forearm, "forearm_m");
  require_length(d.tip, "tip_m");
  constexpr JointKind kTurn = JointKind::kRevolute;
  // A pitch is positive upwards, hence about -y.
  const Point3 yaw{0.0, 0.0, 1.0}, pitch{0.0, -1.0, 0.0}, roll{1.0, 0.0, 0.0};
  SerialChainParameters chain;
  chain.joints = {
      {"turntable", kTurn, true, "", {}, yaw, d.turntable_lower, d.turntable_upper},
      {"shoulder", kTurn, true, "", {}, pitch, d.shoulder_lower, d.shoulder_upper},
      {"elbow", kTurn, true, "", along_x(d.upper_arm), pitch, d.elbow_lower, d.elbow_upper},
      {"gimbal_yaw", kTurn, false, "", along_x(d.forearm), yaw, d.gimbal_lower, d.gimbal_upper},
      {"gimbal_pitch", kTurn, false, "", {}, pitch, d.gimbal_lower, d.gimbal_upper},
      {"gimbal_roll", kTurn, false, "", {}, roll, d.roll_lower, d.roll_upper},
  };
  return chain;
}

std::unique_ptr<Kinematics> make_stylus(const StylusDimensions& dimensions,
                                        std::vector<ChainOutput> outputs) {
  SerialChainParameters chain = stylus_chain(dimensions);
  if (outputs.empty()) outputs = {{"tip", "", OutputKind::kFrame, along_x(dimensions.tip)}};
  chain.outputs = std::move(outputs);
  return make_serial_chain(chain);
}

}  // namespace haptic::core
