#pragma once
/// The minimum-jerk profile of human point-to-point movements: the position that goes from 0 to 1
/// with zero velocity and acceleration at both ends and the least integral of squared jerk. Source:
/// T. Flash, N. Hogan, J. Neurosci. 5(7):1688-1703, 1985.

#include <algorithm>

namespace haptic::hw {

/// `phase`: time since the start over the movement's duration; clamped to [0, 1].
[[nodiscard]] inline double minimum_jerk(double phase) noexcept {
  const double p = std::clamp(phase, 0.0, 1.0);
  return p * p * p * (10.0 + p * (-15.0 + 6.0 * p));
}

}  // namespace haptic::hw
