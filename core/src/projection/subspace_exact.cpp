#include "haptic/core/projection/subspace_exact.hpp"

namespace haptic::core {

SubspaceExact::SubspaceExact(const ProjectionModel& model)
    : model_(model),
      solver_(model),
      x_at_(VecX::Zero(model.n_x())),
      r_(VecX::Zero(model.n_x())),
      J_(MatXQ::Zero(model.n_x(), model.layout().n_q())),
      uniform_(model.metric().is_uniform(0, model.n_x())) {}

void SubspaceExact::reset() noexcept {
  has_solution_ = false;
  target_.reset();
}

void SubspaceExact::project(const Probe& probe, const VecX& x, const VecX& /*dx*/,
                            const VecA& stiffness, bool proxy_changed, Projection& out) noexcept {
  if (model_.prior()) {
    solve_with_prior(probe, x, stiffness, proxy_changed);
  } else if (proxy_changed || !has_solution_) {
    solve(probe, x, stiffness);
  }
  has_solution_ = solution_.status != ProjectionStatus::kMapFailed;
  out = solution_;
}

void SubspaceExact::solve(const Probe& probe, const VecX& x, const VecA& stiffness) noexcept {
  const Kinematics& kinematics = model_.kinematics();
  const InverseStatus inverse = kinematics.inverse(x, solution_.q_star);
  if (inverse == InverseStatus::kNotOffered) {
    const VecQ seed = seed_near(probe.q);
    solver_.solve(x, seed, stiffness, solution_);
    return;
  }
  if (inverse == InverseStatus::kUnreachable && !uniform_) {
    const VecQ seed = solution_.q_star;
    solver_.solve(x, seed, stiffness, solution_);
    if (solution_.status == ProjectionStatus::kConverged) {
      solution_.status = ProjectionStatus::kUnreachable;
    }
    return;
  }
  solution_.status =
      inverse == InverseStatus::kExact ? ProjectionStatus::kExact : ProjectionStatus::kUnreachable;
  solution_.condition = 0.0;
  if (kinematics.evaluate(solution_.q_star, x_at_, J_) != MapStatus::kOk) {
    solution_.status = ProjectionStatus::kMapFailed;
    return;
  }
  kinematics.space().difference(x, x_at_, r_);
  model_.metric().weigh(r_);
  solution_.residual = r_.norm();
}

void SubspaceExact::solve_with_prior(const Probe& probe, const VecX& x, const VecA& stiffness,
                                     bool proxy_changed) noexcept {
  const DofLayout& layout = model_.layout();
  const VecQ& target = target_.at(probe.q, layout, proxy_changed || !has_solution_);
  solver_.set_prior(model_.prior_weight(stiffness), target);
  const VecQ seed = seed_near(probe.q);
  solver_.solve(x, seed, stiffness, solution_);
  const Prior& prior = *model_.prior();
  solution_.storage = 0.5 * solution_.residual * solution_.residual / prior.weight;
  for (int i = 0; i < layout.n_n(); ++i) {
    const double d = solution_.q_star[layout.sensed(i)] - target[layout.sensed(i)];
    solution_.storage += 0.5 * prior.sensed_stiffness[i] * d * d;
  }
}

/// The last solution, told as near to the device as the same pose can be: a palm that turns on
/// beyond pi must not meet the end of its box.
VecQ SubspaceExact::seed_near(const VecQ& q) const noexcept {
  if (!has_solution_) return q;
  VecQ seed = solution_.q_star;
  model_.kinematics().nearest_representative(q, seed);
  return seed;
}

}  // namespace haptic::core
