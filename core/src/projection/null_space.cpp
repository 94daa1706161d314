#include "haptic/core/projection/null_space.hpp"

#include "haptic/core/projection/virtual_stiffness.hpp"

namespace haptic::core {

NullSpace::NullSpace(const Kinematics& kinematics)
    : kinematics_(&kinematics),
      mean_J_a_(kinematics.mean_actuated_jacobian()),
      solver_(kinematics.space().n_x(), kinematics.layout()),
      tau_a_(VecA::Zero(kinematics.layout().n_a())) {}

void NullSpace::project(const Probe& probe, const VecX& dx, const VecA& stiffness,
                        Projection& out) noexcept {
  solver_.solve(probe.J, dx, stiffness);
  // Eq. (4) with Z_x = z_x I; J_a^T (I - J_n J_n^+) dx = R22^T b_2 of the QR of [J_n | J_a].
  tau_a_ = virtual_stiffness(stiffness, mean_J_a_) * solver_.null_space_force();
  anchor_for(tau_a_, stiffness, kinematics_->layout(), probe.q, out.q_star);
  out.status = solver_.status();
  out.residual = solver_.residual();
  out.condition = solver_.condition();
}

}  // namespace haptic::core
