#pragma once
/// What the work-precision figures are measured on: a map, a motion of the device on it, and what a
/// stop makes of that motion, frame by frame.

#include <memory>
#include <string>
#include <vector>

#include "haptic/core/model/kinematics.hpp"

namespace haptic::report {

struct Study {
  std::string map{};
  std::string error_unit{};  ///< of the actuated DoFs
  std::shared_ptr<const core::Kinematics> kinematics{};
  std::vector<core::VecQ> q{};       ///< the device, one per frame
  std::vector<core::VecX> x{};       ///< the proxy
  std::vector<core::VecQ> q_star{};  ///< argmin ||x - f(q*)||, converged to 1e-12 of the box
};

/// One second of motion at `rate_hz` frames per second. finger, hand (five fingers): flexion by 25
/// and 30 degrees about (30, 35), stopped at (25, 30). tracked_hand: that hand on a palm that moves
/// and turns, known by eleven points; chain: six joints, four of them actuated, three points; in both
/// the proxy is out of shape by 1 mm, so that no q* meets it. Throws SceneError where a reference
/// does not converge or lies on the box.
[[nodiscard]] Study finger_study(double rate_hz);
[[nodiscard]] Study hand_study(double rate_hz);
[[nodiscard]] Study tracked_hand_study(double rate_hz);
[[nodiscard]] Study chain_study(double rate_hz);

}  // namespace haptic::report
