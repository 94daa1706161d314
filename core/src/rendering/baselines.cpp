#include "haptic/core/rendering/baselines.hpp"

namespace haptic::core {

double virtual_stiffness(const VecA& stiffness, double mean_J_a) noexcept {
  return mean_J_a > 0.0 ? stiffness.mean() / (mean_J_a * mean_J_a) : 0.0;
}

void anchor_for(const VecA& tau_a, const VecA& stiffness, const DofLayout& layout, const VecQ& q,
                VecQ& q_star) noexcept {
  q_star = q;
  for (int i = 0; i < layout.n_a(); ++i) {
    if (stiffness[i] > 0.0) q_star[layout.actuated(i)] += tau_a[i] / stiffness[i];
  }
}

Standard::Standard(const ProjectionModel& model)
    : model_(model), tau_a_(VecA::Zero(model.layout().n_a())) {}

void Standard::project(const Probe& probe, const VecX& /*x*/, const VecX& dx, const VecA& stiffness,
                       bool /*proxy_changed*/, Projection& out) noexcept {
  const DofLayout& layout = model_.layout();
  const MatXQ& J = model_.metric().weighed(probe.J, J_W_);
  const VecX& d = model_.metric().weighed(dx, dx_W_);
  const double z_x = virtual_stiffness(stiffness, model_.mean_actuated_jacobian());
  for (int i = 0; i < layout.n_a(); ++i) {
    tau_a_[i] = z_x * J.col(layout.actuated(i)).dot(d);  // Eq. (1)
  }
  anchor_for(tau_a_, stiffness, layout, probe.q, out.q_star);
  out.status = ProjectionStatus::kExact;
}

NullSpace::NullSpace(const ProjectionModel& model)
    : model_(model),
      solver_(model.n_x(), model.layout(), model.coupling()),
      tau_a_(VecA::Zero(model.layout().n_a())) {}

void NullSpace::project(const Probe& probe, const VecX& /*x*/, const VecX& dx,
                        const VecA& stiffness, bool /*proxy_changed*/, Projection& out) noexcept {
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
