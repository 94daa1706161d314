#include "haptic/core/projection/monotone_envelope.hpp"

#include <cmath>

namespace haptic::core {

namespace {

/// Steps of Gauss-Newton per point; one from a neighbour's solution leaves 1e-2 of the way's
/// curvature, two 1e-4 (METHOD 3.1).
constexpr int kSteps = 2;

}  // namespace

MonotoneEnvelope::MonotoneEnvelope(const Kinematics& kinematics)
    : kinematics_(&kinematics),
      actuated_(kinematics.layout().actuated(0)),
      solver_(kinematics.space().n_x(), kinematics.layout()),
      one_(VecA::Ones(kinematics.layout().n_a())),
      q_(VecQ::Zero(kinematics.layout().n_q())),
      x_at_(VecX::Zero(kinematics.space().n_x())),
      x_(x_at_),
      r_(x_at_),
      J_(MatXQ::Zero(kinematics.space().n_x(), kinematics.layout().n_q())) {
  best_ = q_;
}

EnvelopeAnswer MonotoneEnvelope::apply(const Probe& probe, const VecX& dx, RendererKind renderer,
                                       Projection& out) noexcept {
  solver_.solve(probe.J, dx, one_);
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
  for (int n = 0; n < kSteps; ++n) {
    if (kinematics_->evaluate(q_, x_, J_) != MapStatus::kOk) return false;
    kinematics_->space().difference(x_at, x_, r_);
    solver_.solve(J_, r_, one_);
    q_ += solver_.dq();
  }
  const auto& dofs = kinematics_->dofs();
  for (Eigen::Index i = 0; i < q_.size(); ++i) {
    const DofSpec& dof = dofs[static_cast<std::size_t>(i)];
    if (!(q_[i] >= dof.lower && q_[i] <= dof.upper)) return false;
  }
  return true;
}

}  // namespace haptic::core
