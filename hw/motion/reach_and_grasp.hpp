#pragma once
/// Finger motion of our own making: repeated reach-and-grasp strokes of an index finger. Reaching,
/// the finger opens; grasping, it closes, PIP a little behind MCP; it holds, opens and pauses.
/// Every stroke varies in amplitude, speed and pause. Physiological tremor lies on top. Sources:
/// minimum-jerk strokes, see minimum_jerk.hpp; tremor of 8-12 Hz, R. J. Elble, W. C. Koller,
/// Tremor, 1990, about 1 mrad at the fingers' joints. Amplitudes, durations and lag are chosen to
/// look like the grasps recorded of people and stay in the reach of the exoskeleton
/// (core/METHOD.md#finger-linkage).

#include <cstdint>
#include <iosfwd>
#include <vector>

namespace haptic::hw {

struct ReachAndGrasp {
  std::uint64_t seed{1};
  double seconds{20.0};      ///< length, 1 to 3600
  double rate{100.0};        ///< rows per second, 1 to 1000
  double tremor_rms{0.001};  ///< rad, per joint; 0: none
};

struct JointAngles {
  double time{0.0};  ///< s
  double mcp{0.0};   ///< rad, flexion positive
  double pip{0.0};   ///< rad
};

/// Rows at 0, 1/rate, ... up to and including `seconds`. The same options give the same rows.
/// Throws DeviceError naming the option that is out of its range.
[[nodiscard]] std::vector<JointAngles> make_reach_and_grasp(const ReachAndGrasp& options);

/// CSV: header time_s,q_o1_mcp_rad,q_o2_pip_rad, six decimals, independent of the locale.
void write_motion_csv(std::ostream& out, const std::vector<JointAngles>& rows);

}  // namespace haptic::hw
