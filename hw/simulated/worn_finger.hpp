#pragma once
/// A simulated finger with its exoskeleton as the devices configure it: its mechanics, and the
/// sensors through which the loop sees it.

#include <cmath>

#include "hw/random.hpp"
#include "hw/simulated/finger_physics.hpp"

namespace haptic::hw {

struct WornFinger {
  FingerParameters finger{};
  double actuator_force_limit{40.0};  ///< N
  double noise_l_x{0.0};              ///< m rms
  double noise_q_B{0.0};              ///< rad rms
  double resolution_l_x{0.0};         ///< m; 0: none
  double resolution_q_B{0.0};         ///< rad; 0: none

  /// Replaces (l_x, q_B) at `first` in q by what the sensors say. Both numbers are drawn in every
  /// sample, so that one sensor's noise does not depend on the other's.
  void measure(core::VecQ& q, Eigen::Index first, Gaussian& noise) const noexcept {
    const double of_l_x = noise_l_x * noise();
    const double of_q_B = noise_q_B * noise();
    q[first] = quantised(q[first] + of_l_x, resolution_l_x);
    q[first + 1] = quantised(q[first + 1] + of_q_B, resolution_q_B);
  }

 private:
  static double quantised(double value, double quantum) noexcept {
    return quantum > 0.0 ? quantum * std::round(value / quantum) : value;
  }
};

}  // namespace haptic::hw
