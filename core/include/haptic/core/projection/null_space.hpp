#pragma once
/// Eq. (3)-(4): tau_a = J_a^T (I - J_n J_n^+) Z_x dx, the force optimised under underactuation.

#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/projection/projection.hpp"

namespace haptic::core {

class NullSpace {
 public:
  explicit NullSpace(const Kinematics& kinematics);
  void project(const Probe& probe, const VecX& dx, const VecA& stiffness, Projection& out) noexcept;

 private:
  const Kinematics* kinematics_;
  double mean_J_a_;
  LeastSquares solver_;
  VecA tau_a_{};
};

}  // namespace haptic::core
