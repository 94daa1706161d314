#include "haptic/core/projection/null_space.hpp"

#include "haptic/core/projection/virtual_stiffness.hpp"

namespace haptic::core {

NullSpace::NullSpace(const ProjectionModel& model)
    : model_(model),
      solver_(model.n_x(), model.layout(), model.coupling()),
      tau_a_(VecA::Zero(model.layout().n_a())) {}

void NullSpace::project(const Probe& probe, const VecX& dx, const VecA& stiffness,
                        Projection& out) noexcept {
  solver_.solve(model_.metric().weighed(probe.J, J_W_), model_.metric().weighed(dx, dx_W_),
                stiffness);
  // Eq. (4) with Z_x = z_x W; J_a^T (I - J_n J_n^+) dx = R22^T b_2 of the QR of [J_n | J_a].
  tau_a_ =
      virtual_stiffness(stiffness, model_.mean_actuated_jacobian()) * solver_.null_space_force();
  anchor_for(tau_a_, stiffness, model_.layout(), probe.q, out.q_star);
  out.status = solver_.status();
  out.residual = solver_.residual();
  out.condition = solver_.condition();
}

}  // namespace haptic::core
