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

Baseline::Baseline(RendererKind kind, const ProjectionModel& model)
    : null_space_(kind == RendererKind::kNullSpace),
      model_(model),
      solver_(model.n_x(), model.layout(), model.coupling()),
      tau_a_(VecA::Zero(model.layout().n_a())) {}

void Baseline::project(const Probe& probe, const VecX& /*x*/, const VecX& dx, const VecA& stiffness,
                       bool /*proxy_changed*/, Projection& out) noexcept {
  const DofLayout& layout = model_.layout();
  const MatXQ& J = model_.metric().weighed(probe.J, J_W_);
  const VecX& d = model_.metric().weighed(dx, dx_W_);
  const double z_x = virtual_stiffness(stiffness, model_.mean_actuated_jacobian());
  out.status = ProjectionStatus::kExact;
  if (null_space_) {
    // Eq. (4) with Z_x = z_x W; J_a^T (I - J_n J_n^+) dx = R22^T b_2 of the QR of [J_n | J_a].
    solver_.solve(J, d, stiffness);
    tau_a_ = z_x * solver_.null_space_force();
    out.status = solver_.status();
    out.residual = solver_.residual();
    out.condition = solver_.condition();
  } else {
    for (int i = 0; i < layout.n_a(); ++i) {
      tau_a_[i] = z_x * J.col(layout.actuated(i)).dot(d);  // Eq. (1)
    }
  }
  anchor_for(tau_a_, stiffness, layout, probe.q, out.q_star);
}

}  // namespace haptic::core
