#include "haptic/core/projection/standard.hpp"

#include "haptic/core/projection/virtual_stiffness.hpp"

namespace haptic::core {

Standard::Standard(const ProjectionModel& model)
    : model_(model), tau_a_(VecA::Zero(model.layout().n_a())) {}

void Standard::project(const Probe& probe, const VecX& dx, const VecA& stiffness,
                       Projection& out) noexcept {
  const DofLayout& layout = model_.layout();
  const MatXQ& J = model_.metric().weighed(probe.J, J_W_);
  const VecX& d = model_.metric().weighed(dx, dx_W_);
  const double z_x = virtual_stiffness(stiffness, model_.mean_actuated_jacobian());
  for (int i = 0; i < layout.n_a(); ++i) {
    tau_a_[i] = z_x * J.col(layout.actuated(i)).dot(d);  // Eq. (1)
  }
  anchor_for(tau_a_, stiffness, layout, probe.q, out.q_star);
  out.status = ProjectionStatus::kExact;
  out.residual = 0.0;
  out.condition = 0.0;
}

}  // namespace haptic::core
