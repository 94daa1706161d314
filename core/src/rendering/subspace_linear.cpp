#include "haptic/core/rendering/subspace_linear.hpp"

#include <limits>

#include "haptic/core/linear/minimum_norm.hpp"

namespace haptic::core {

SubspaceLinear::SubspaceLinear(const ProjectionModel& model)
    : model_(model),
      solver_(model.n_x(), model.layout(), model.coupling()),
      unbounded_(VecQ::Constant(model.layout().n_q(), std::numeric_limits<double>::infinity())) {}

void SubspaceLinear::project(const Probe& probe, const VecX& /*x*/, const VecX& dx,
                             const VecA& stiffness, bool proxy_changed, Projection& out) noexcept {
  const MatXQ& J = model_.metric().weighed(probe.J, J_W_);
  const VecX& d = model_.metric().weighed(dx, dx_W_);
  if (model_.prior()) {
    static_cast<void>(target_.at(probe.q, model_.layout(), proxy_changed));
    project_with_prior(probe, J, d, stiffness, out);
    return;
  }
  solver_.solve(J, d, stiffness);
  out.q_star = probe.q + solver_.dq();  // Eq. (8)
  out.status = solver_.status();
  out.residual = solver_.residual();
  out.condition = solver_.condition();
}

void SubspaceLinear::project_with_prior(const Probe& probe, const MatXQ& J, const VecX& dx,
                                        const VecA& stiffness, Projection& out) noexcept {
  const int n_q = model_.layout().n_q();
  with_prior_.begin(model_.n_x() + n_q, n_q);
  with_prior_.add(J, dx);
  model_.add_prior(model_.prior_weight(stiffness),
                   target_.at(probe.q, model_.layout(), false) - probe.q, with_prior_);
  with_prior_.solve(-unbounded_, unbounded_, rank_metric_root(J, model_.layout(), stiffness));
  out.q_star = probe.q + with_prior_.p();
  out.status = with_prior_.status();
  out.residual = (dx - J.lazyProduct(with_prior_.p())).norm();
  out.condition = with_prior_.condition();
}

}  // namespace haptic::core
