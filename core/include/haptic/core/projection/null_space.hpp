#pragma once
/// Eq. (3)-(4): tau_a = J_a^T (I - J_n J_n^+) Z_x dx, the force optimised under underactuation.
/// With Z_x = z_x W, and Eq. (3) in the metric W^{-1} on forces (core/METHOD.md#solver-choice).

#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/projection/projection.hpp"
#include "haptic/core/projection/projection_model.hpp"

namespace haptic::core {

class NullSpace {
 public:
  explicit NullSpace(const ProjectionModel& model);
  void project(const Probe& probe, const VecX& dx, const VecA& stiffness, Projection& out) noexcept;

 private:
  ProjectionModel model_;
  LeastSquares solver_;
  VecA tau_a_{};
  VecX dx_W_{};  ///< W^{1/2} dx
  MatXQ J_W_{};  ///< W^{1/2} J
};

}  // namespace haptic::core
