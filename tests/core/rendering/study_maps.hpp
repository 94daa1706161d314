#pragma once
/// The curved maps of tests/report/STUDY.md on which a prior is judged.

#include <cmath>
#include <string>
#include <vector>

#include "haptic/core/model/serial_chain.hpp"

namespace haptic::core::samples {

/// The map of tests/report/STUDY.md#curved-wide-map: curved, wide, q_a = (q0, q1), q_n = q2.
class WideMap final : public Kinematics {
 public:
  WideMap()
      : Kinematics({{"q0", Unit::kRadian, true, -1.0, 1.0},
                    {"q1", Unit::kRadian, true, -1.0, 1.0},
                    {"q2", Unit::kRadian, false, -1.0, 1.0}},
                   ConfigurationSpace({{"x0", Unit::kMetre}, {"x1", Unit::kMetre}})) {}

  MapStatus evaluate(const VecQ& q, VecX& x, MatXQ& J) const noexcept override {
    const Eigen::Matrix<double, 2, 3> A =
        (Eigen::Matrix<double, 2, 3>() << 1, .6, -.4, .3, 1.2, .8).finished();
    const Eigen::Vector2d z = A * q;
    x = Eigen::Vector2d(std::sin(z[0]) + .3 * q[1] * q[2], z[1] + .2 * z[0] * z[0]);
    J.resize(2, 3);
    J.row(0) = std::cos(z[0]) * A.row(0);
    J(0, 1) += .3 * q[2];
    J(0, 2) += .3 * q[1];
    J.row(1) = A.row(1) + .4 * z[0] * A.row(0);
    return MapStatus::kOk;
  }
};

/// The hand of tests/report/STUDY.md#larger-devices: a tracked wrist and fingers of four joints
/// (abduction, three flexions), known by three points per finger. The wrist is sensed, and the
/// first flexion of each finger is actuated.
inline std::unique_ptr<Kinematics> hand_of_points(int fingers) {
  SerialChainParameters hand;
  hand.palm = TrackedPalm{.position_lower = -0.1, .position_upper = 0.1};
  constexpr Point3 kAcross{0.0, 1.0, 0.0};
  for (int f = 0; f < fingers; ++f) {
    const std::string n = std::to_string(f);
    const Point3 root{0.09, 0.02 * (f - 0.5 * (fingers - 1)), 0.0};
    const auto joint = [&](const std::string& name, bool actuated, const std::string& parent,
                           Point3 at, Point3 axis, double lower, double upper) {
      hand.joints.push_back(
          {name + n, JointKind::kRevolute, actuated, parent, {at, {}}, axis, lower, upper});
    };
    joint("abduction", false, "base", root, {0.0, 0.0, 1.0}, -0.35, 0.35);
    joint("mcp", true, "abduction" + n, {}, kAcross, 0.0, 1.57);
    joint("pip", false, "mcp" + n, {0.045, 0.0, 0.0}, kAcross, 0.0, 1.75);
    joint("dip", false, "pip" + n, {0.025, 0.0, 0.0}, kAcross, 0.0, 1.2);
    for (const auto& [link, length] : {std::pair{"mcp", 0.045}, {"pip", 0.025}, {"dip", 0.020}}) {
      hand.outputs.push_back({link + n, link + n, OutputKind::kPoint, {{length, 0.0, 0.0}, {}}});
    }
  }
  return make_serial_chain(hand);
}

}  // namespace haptic::core::samples
