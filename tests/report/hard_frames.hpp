#pragma once
/// Frames at which finding q* of Eq. (6) is hard, on a finger and on an arm, with the least
/// residual that any pose in the limits has (tests/report/STUDY.md#hard-frames).

#include <string>
#include <vector>

#include "haptic/core/model/serial_chain.hpp"

namespace haptic::report {

struct HardFrames {
  std::string map{};   ///< "finger", "arm"
  std::string unit{};  ///< of X
  std::string what{};  ///< "random", "near_singular", "at_the_box", "unreachable", "at_ties"
  std::shared_ptr<const core::Kinematics> kinematics{};
  std::vector<core::VecQ> q{};  ///< the device: where every method starts from
  std::vector<core::VecX> x{};  ///< the proxy
  std::vector<double> least{};  ///< residual of the best pose known so far
};

/// Three joints and a point: turret, shoulder, elbow. KDL can have it too.
[[nodiscard]] core::SerialChainParameters hard_arm();

/// Five sets of `count` frames, the same in every run; a map without frames of a kind has none.
/// random: q and the q* that x is the image of are anywhere. near_singular: both are among the 1 %
/// of random poses with the largest condition of J, columns scaled by the box. at_the_box: x is the
/// image of a pose 5 % of its range beyond one limit of the box. unreachable: x is out of reach.
/// at_ties: two poses or more are equally near to x, to 1e-9.
[[nodiscard]] std::vector<HardFrames> hard_frames_of_finger(int count);
[[nodiscard]] std::vector<HardFrames> hard_frames_of_arm(int count);

/// ||x (-) f(q)|| with q moved into the box; NaN if f has no value there or a slider is beyond its
/// end.
[[nodiscard]] double residual_inside(const core::Kinematics& map, core::VecQ q,
                                     const core::VecX& x);

}  // namespace haptic::report
