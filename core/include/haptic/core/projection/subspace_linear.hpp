#pragma once
/// Eq. (7)-(8): dq = argmin ||dx - J dq||^2, q* = q + dq, the linearised subspace proxy.

#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/projection/projection.hpp"

namespace haptic::core {

class SubspaceLinear {
 public:
  explicit SubspaceLinear(const Kinematics& kinematics);
  void project(const Probe& probe, const VecX& dx, const VecA& stiffness, Projection& out) noexcept;

 private:
  LeastSquares solver_;
};

}  // namespace haptic::core
