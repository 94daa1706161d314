#pragma once
/// Eq. (7)-(8): dq = argmin ||dx - J dq||_W^2, q* = q + dq, the linearised subspace proxy. With a
/// prior (core/METHOD.md#projection-algorithm, case B) its terms are added, linear as they are.

#include "haptic/core/linear/boxed_least_squares.hpp"
#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/rendering/prior_target.hpp"
#include "haptic/core/rendering/projection.hpp"
#include "haptic/core/rendering/projection_model.hpp"

namespace haptic::core {

class SubspaceLinear {
 public:
  explicit SubspaceLinear(const ProjectionModel& model);
  /// See Renderer::project.
  void project(const Probe& probe, const VecX& x, const VecX& dx, const VecA& stiffness,
               bool proxy_changed, Projection& out) noexcept;
  /// Forgets q_n^ref.
  void reset() noexcept { target_.reset(); }

 private:
  void project_with_prior(const Probe& probe, const MatXQ& J, const VecX& dx, const VecA& stiffness,
                          Projection& out) noexcept;

  ProjectionModel model_;
  LeastSquares solver_;
  PriorTarget target_;
  BoxedLeastSquares with_prior_{};
  VecQ unbounded_{};
  VecX dx_W_{};  ///< W^{1/2} dx
  MatXQ J_W_{};  ///< W^{1/2} J
};

}  // namespace haptic::core
