#pragma once
/// Paths of a device through its poses, with the proxy held: what the paper's Fig. 4 is made of
/// (section VI.C; tests/report/STUDY.md#fig-4-finger_sign_change and
/// tests/report/STUDY.md#finite-difference-rule-finger_sign_change).

#include <vector>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

struct Trajectory {
  std::vector<VecX> x_probe{};     ///< the path in X, sample by sample
  std::vector<VecQ> q{};           ///< the same in Q, by the map's inverse
  std::vector<char> gap_before{};  ///< != 0: nothing was measured before this sample; empty: no gap
  std::vector<VecQ> cycle{};       ///< one closed cycle; its last sample joins its first
  int beyond_reach{0};             ///< samples whose nearest pose in reach was taken
  bool closed_by_line{false};      ///< `cycle` was closed by a straight line in X
};

/// q_o1 = offset1 + A1 (1 - cos wt)/2, q_o2 = offset2 + A2 (1 - cos(wt - psi))/2:
/// tests/report/STUDY.md#fig-4-finger_sign_change. Angles in rad.
struct GraspCycle {
  double A1{0.0}, A2{0.0}, psi{0.0};
  double offset1{4.0 * 0.017453292519943295};  ///< 4 deg
  double offset2{4.0 * 0.017453292519943295};
  double frequency{0.5};      ///< Hz
  double sample_rate{500.0};  ///< Hz; a cycle must be a whole number of samples
  int cycles{4};
};

/// The path of a two-joint device. Its cycle is the second one (of the only one, the first), end
/// point excluded. Throws SceneError: not two coordinates, no inverse, a cycle that is not a whole
/// number of samples, or < 3 of them.
[[nodiscard]] Trajectory sampled(const Kinematics& kinematics, const GraspCycle& grasp);

/// A recorded path, which is open: for the cycle it is closed by a straight line in X in steps of
/// the path's mean step. Throws SceneError: fewer than 3 samples, a sample of the wrong size, no
/// inverse.
[[nodiscard]] Trajectory recorded(const Kinematics& kinematics, std::vector<VecX> x_probe,
                                  std::vector<char> gap_before = {});

}  // namespace haptic::core
