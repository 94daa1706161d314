#pragma once
/// The methods that the paper compares its subspace proxy with. They compute a force from a virtual
/// stiffness Z_x = z_x W and answer with the anchor that makes it.

#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/rendering/projection.hpp"
#include "haptic/core/rendering/projection_model.hpp"
#include "haptic/core/rendering/renderer_kind.hpp"

namespace haptic::core {

/// z_x of the paper's Z_x = z_x I: the actuator's stiffness with the average scale of J_a factored
/// out (section VI.C). Unit of force per unit of x. `stiffness`: n_a. 0 if J_a = 0.
[[nodiscard]] double virtual_stiffness(const VecA& stiffness, double mean_J_a) noexcept;

/// q* with S q* = q_a + Z_q^{-1} tau_a and the sensed part as it is: the anchor that makes
/// tau_a = Z_q S(q* - q). A DoF of stiffness 0 has no anchor but its own position, and no force.
void anchor_for(const VecA& tau_a, const VecA& stiffness, const DofLayout& layout, const VecQ& q,
                VecQ& q_star) noexcept;

/// Eq. (1): tau_a = J_a^T Z_x dx, the standard method, which ignores underactuation. Or Eq. (3) and
/// (4): tau_a = J_a^T (I - J_n J_n^+) Z_x dx, the force optimised under underactuation, with Eq.
/// (3) in the metric W^{-1} on forces (core/METHOD.md#solver-choice).
class Baseline {
 public:
  Baseline(RendererKind kind, const ProjectionModel& model);
  /// See Renderer::project.
  void project(const Probe& probe, const VecX& x, const VecX& dx, const VecA& stiffness,
               bool proxy_changed, Projection& out) noexcept;

 private:
  bool null_space_;
  ProjectionModel model_;
  LeastSquares solver_;
  VecA tau_a_{};
  VecX dx_W_{};  ///< W^{1/2} dx
  MatXQ J_W_{};  ///< W^{1/2} J
};

}  // namespace haptic::core
