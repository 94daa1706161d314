#include "haptic/core/rendering/monotone_envelope.hpp"

#include <cmath>

namespace haptic::core {

namespace {

/// Steps of Gauss-Newton per point; one from a neighbour's solution leaves 1e-2 of the way's
/// curvature, two 1e-4 (tests/report/STUDY.md#work-and-precision-finger_sign_change).
constexpr int kSteps = 2;

}  // namespace

MonotoneEnvelope::MonotoneEnvelope(const ProjectionModel& model)
    : model_(model),
      actuated_(model.layout().actuated(0)),
      solver_(model.n_x(), model.layout(), model.coupling()),
      one_(VecA::Ones(model.layout().n_a())),
      q_(VecQ::Zero(model.layout().n_q())),
      x_at_(VecX::Zero(model.n_x())),
      x_(x_at_),
      r_(x_at_),
      J_(MatXQ::Zero(model.n_x(), model.layout().n_q())) {
  best_ = q_;
}

EnvelopeAnswer MonotoneEnvelope::apply(const Probe& probe, const VecX& dx, RendererKind renderer,
                                       Projection& out) noexcept {
  const TaskMetric& metric = model_.metric();
  solver_.solve(metric.weighed(probe.J, J_W_), metric.weighed(dx, dx_W_), one_);
  const double towards = solver_.dq()[actuated_] < 0.0 ? -1.0 : 1.0;
  const double q_a = probe.q[actuated_];
  const double at_proxy = towards * (out.q_star[actuated_] - q_a);
  double most = at_proxy;
  if (renderer == RendererKind::kSubspaceExact) {
    q_ = probe.q;
    for (int k = 1; k <= kPoints; ++k) {
      x_at_ = probe.x_probe + (static_cast<double>(k) / (kPoints + 1)) * dx;
      if (!reach(x_at_)) break;
      const double pull = towards * (q_[actuated_] - q_a);
      if (pull > most) {
        most = pull;
        best_ = q_;
      }
    }
  }
  if (!(most >= 0.0)) return EnvelopeAnswer::kWithheld;
  if (most == at_proxy) return EnvelopeAnswer::kProxy;
  out.q_star = best_;
  return EnvelopeAnswer::kEarlier;
}

bool MonotoneEnvelope::reach(const VecX& x_at) noexcept {
  const InverseStatus closed = model_.kinematics().inverse_inside(x_at, q_);
  if (closed != InverseStatus::kNotOffered) return closed == InverseStatus::kExact;
  for (int n = 0; n < kSteps; ++n) {
    if (model_.kinematics().evaluate(q_, x_, J_) != MapStatus::kOk) return false;
    model_.kinematics().space().difference(x_at, x_, r_);
    solver_.solve(model_.metric().weighed(J_, J_W_), model_.metric().weighed(r_, dx_W_), one_);
    q_ += solver_.dq();
  }
  const auto& dofs = model_.kinematics().dofs();
  for (Eigen::Index i = 0; i < q_.size(); ++i) {
    const DofSpec& dof = dofs[static_cast<std::size_t>(i)];
    if (!(q_[i] >= dof.lower && q_[i] <= dof.upper)) return false;
  }
  return true;
}

}  // namespace haptic::core
