#pragma once
/// The direction guard (METHOD 2.4): the elastic force must not point away from the proxy as the
/// finger feels it, tau_a^T (S J^+ dx) >= 0; otherwise it is withheld for the tick.

#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/projection/projection.hpp"
#include "haptic/core/projection/projection_model.hpp"

namespace haptic::core {

class DirectionGuard {
 public:
  /// The model is copied; its kinematics must outlive the guard. `stiffness` (n_a; size 0: ones)
  /// decides where J does not have full column rank, as it does for Eq. (8).
  explicit DirectionGuard(const ProjectionModel& model, const VecA& stiffness = {});
  /// True where tau_a (n_a) points towards the proxy, or dx = 0. One linearised solve.
  [[nodiscard]] bool allows(const Probe& probe, const VecX& dx, const VecA& tau_a) noexcept;

 private:
  ProjectionModel model_;
  VecA stiffness_;
  LeastSquares solver_;
  VecX dx_W_{};  ///< W^{1/2} dx
  MatXQ J_W_{};  ///< W^{1/2} J
};

}  // namespace haptic::core
