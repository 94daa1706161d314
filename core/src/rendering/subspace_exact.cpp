#include "haptic/core/rendering/subspace_exact.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

constexpr double kApart = 0.02;       // of the box: two optima, not one that moved
constexpr double kHysteresis = 0.01;  // of the residual
constexpr double kStep = 0.001;       // of the box, per tick
constexpr double kJump = 10.0;        // of the box, per rad of x: more than any pose in reach

}  // namespace

SubspaceExact::SubspaceExact(const ProjectionModel& model)
    : model_(model),
      solver_(model),
      x_at_(VecX::Zero(model.n_x())),
      r_(VecX::Zero(model.n_x())),
      J_(MatXQ::Zero(model.n_x(), model.layout().n_q())),
      uniform_(model.metric().is_uniform(0, model.n_x())) {
  box_ = VecQ::Zero(model.layout().n_q());
  for (int i = 0; i < model.layout().n_q(); ++i) {
    const DofSpec& dof = model.kinematics().dofs()[static_cast<std::size_t>(i)];
    if (std::isfinite(dof.upper - dof.lower)) box_[i] = 1.0 / (dof.upper - dof.lower);
  }
}

void SubspaceExact::reset() noexcept {
  has_solution_ = false;
  release();
  target_.reset();
}

void SubspaceExact::release() noexcept {
  if (solution_.between) has_solution_ = false;
  on_branch_ = going_over_ = solution_.between = false;
}

void SubspaceExact::project(const Probe& probe, const VecX& x, const VecX& /*dx*/,
                            const VecA& stiffness, bool proxy_changed, Projection& out) noexcept {
  if (model_.prior()) {
    solve_with_prior(probe, x, stiffness, proxy_changed);
  } else if (proxy_changed || !has_solution_) {
    const VecQ in_use = solution_.q_star;
    solve(probe, x, stiffness);
    solution_.between = false;
    if (on_branch_) choose_branch(x, stiffness);
    on_branch_ = solution_.status == ProjectionStatus::kUnreachable || going_over_;
    branch_ = solution_.q_star;
    x_before_ = x;
    if (going_over_) solution_.q_star = in_use;
  }
  if (going_over_) go_over();
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

void SubspaceExact::choose_branch(const VecX& x, const VecA& stiffness) noexcept {
  if (solution_.status != ProjectionStatus::kUnreachable) return;
  if (!(apart(solution_.q_star, branch_) > kApart)) return;
  solver_.solve(x, branch_, stiffness, local_);
  const bool two = local_.status != ProjectionStatus::kMapFailed &&
                   apart(local_.q_star, solution_.q_star) > kApart;
  if (two && local_.residual <= (1.0 + kHysteresis) * solution_.residual) {
    solution_ = local_;
    solution_.status = ProjectionStatus::kUnreachable;
    solution_.between = true;
    return;
  }
  // Without a second optimum the branch has ended, or x has moved far.
  going_over_ = two || apart(solution_.q_star, branch_) > kJump * (x - x_before_).norm();
}

void SubspaceExact::go_over() noexcept {
  const double way = apart(solution_.q_star, branch_);
  going_over_ = way > kStep;
  solution_.between = going_over_;
  if (going_over_) {
    solution_.q_star += kStep / way * (branch_ - solution_.q_star);
  } else {
    solution_.q_star = branch_;
  }
}

double SubspaceExact::apart(const VecQ& a, const VecQ& b) const noexcept {
  return (a - b).cwiseProduct(box_).cwiseAbs().maxCoeff();
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
