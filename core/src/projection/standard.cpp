#include "haptic/core/projection/standard.hpp"

#include "haptic/core/projection/virtual_stiffness.hpp"

namespace haptic::core {

Standard::Standard(const Kinematics& kinematics)
    : kinematics_(&kinematics),
      mean_J_a_(kinematics.mean_actuated_jacobian()),
      tau_a_(VecA::Zero(kinematics.layout().n_a())) {}

void Standard::project(const Probe& probe, const VecX& dx, const VecA& stiffness,
                       Projection& out) noexcept {
  const DofLayout& layout = kinematics_->layout();
  const double z_x = virtual_stiffness(stiffness, mean_J_a_);
  for (int i = 0; i < layout.n_a(); ++i) {
    tau_a_[i] = z_x * probe.J.col(layout.actuated(i)).dot(dx);  // Eq. (1)
  }
  anchor_for(tau_a_, stiffness, layout, probe.q, out.q_star);
  out.status = ProjectionStatus::kExact;
  out.residual = 0.0;
  out.condition = 0.0;
}

}  // namespace haptic::core
