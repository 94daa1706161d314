// Eq. (6) by Gauss-Newton in the box, case A or Eq. (17) in case B.
//
// Each step solves a linear least-squares problem whose rows are W^{1/2} J, the prior's springs
// and, if damped, Marquardt's diagonal; the box and the mechanism's limits are constraints of that
// problem. A full step is tried first. If it would raise the cost, damped steps are tried, so the
// last iterate is always the best one and a capped solve is still safe to use.
//
// Two details make it converge to rounding. Near the end the cost is flat to rounding while q*
// still moves by its square root: from there on a step counts as long as it is shorter than the one
// before. And along a curved limit a Gauss-Newton step has the wrong length, because the curvature
// of the limit is not in the linear problem: follow_curvature() corrects the length from the cost
// at both ends of the step. Without the first, case B is no gradient (the tank would book noise);
// without the second, a proxy out of reach converges linearly and is reported CAPPED.
#include "haptic/core/rendering/proxy_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic/core/linear/minimum_norm.hpp"

namespace haptic::core {

namespace {

// Marquardt's usual numbers (core/METHOD.md#projection-algorithm).
constexpr double kFirstLambda = 1e-3;
constexpr double kRaise = 8.0;
constexpr double kLower = 0.1;
/// Bounds of the share of a step along a curved limit; a share this close to 1 counts as 1.
constexpr double kLeastShare = 0.1, kMostShare = 4.0, kSameShare = 1e-3;
/// A step that promises less than this share of the cost is rounding.
constexpr double kLeastPromise = 1e-12;
/// A residual of this share of what the box spans in X is rounding.
constexpr double kRounding = 1e-15;
/// A residual below this share of what the box spans in X is none.
constexpr double kNoResidual = 1e-9;

}  // namespace

ProxySolver::ProxySolver(const ProjectionModel& model)
    : model_(model), limits_(model.kinematics()) {
  const int n_q = model.layout().n_q();
  lower_.resize(n_q);
  upper_.resize(n_q);
  for (int i = 0; i < n_q; ++i) {
    const DofSpec& dof = model.kinematics().dofs()[static_cast<std::size_t>(i)];
    lower_[i] = dof.lower;
    upper_[i] = dof.upper;
  }
  for (Point& point : points_) {
    point.q = VecQ::Zero(n_q);
    point.x = point.r = VecX::Zero(model.n_x());
    point.J = MatXQ::Zero(model.n_x(), n_q);
  }
}

void ProxySolver::set_prior(const VecQ& weight, const VecQ& target) noexcept {
  has_prior_ = true;
  prior_weight_ = weight;
  prior_target_ = target;
}

void ProxySolver::solve(const VecX& x, const VecQ& seed, const VecA& stiffness,
                        Projection& out) noexcept {
  here().q = seed.cwiseMax(lower_).cwiseMin(upper_);
  if (!limits_.apart(here().q, VecQ::Zero(seed.size()))) {
    static_cast<void>(limits_.restore(here().q));  // a seed beyond them still leads somewhere
  }
  here().inside = true;
  evaluate(x, here());
  out.q_star = here().q;
  out.residual = out.condition = 0.0;
  out.status = ProjectionStatus::kMapFailed;
  if (!std::isfinite(here().cost)) return;

  metric_root_ = rank_metric_root(here().J, model_.layout(), stiffness);
  marquardt_.setZero(model_.layout().n_q());
  lambda_ = kFirstLambda;
  length_ = std::numeric_limits<double>::infinity();
  share_ = 1.0;
  floor_ = kRounding * kRounding * span2();
  Step last = Step::kTaken;
  for (int i = 0; i < model_.iteration().max_steps && last == Step::kTaken; ++i) last = step(x);
  out.q_star = here().q;
  out.residual = std::sqrt(here().task);
  out.condition = condition_;
  out.status = judge(last);
}

void ProxySolver::evaluate(const VecX& x, Point& point) noexcept {
  point.cost = std::numeric_limits<double>::infinity();
  if (!point.inside) return;
  if (model_.kinematics().evaluate(point.q, point.x, point.J) != MapStatus::kOk) return;
  model_.kinematics().space().difference(x, point.x, point.r);
  model_.metric().weigh(point.r);
  model_.metric().weigh(point.J);
  point.task = point.r.squaredNorm();
  point.cost = point.task;
  if (has_prior_) {
    point.cost += model_.prior_cost(prior_weight_, point.q - prior_target_);
  }
}

void ProxySolver::assemble(double lambda) noexcept {
  const int n_q = model_.layout().n_q();
  const int rows = model_.n_x() + (has_prior_ ? n_q : 0) + (lambda > 0.0 ? n_q : 0);
  linear_.begin(rows, n_q);
  linear_.add(here().J, here().r);
  if (has_prior_) model_.add_prior(prior_weight_, prior_target_ - here().q, linear_);
  if (lambda > 0.0) {
    marquardt_ = marquardt_.cwiseMax(linear_.column_norms());
    linear_.add_diagonal(std::sqrt(lambda) * marquardt_, VecQ::Zero(n_q));
  }
}

double ProxySolver::propose(double lambda) noexcept {
  assemble(lambda);
  linear_.solve(lower_ - here().q, upper_ - here().q, metric_root_);
  step_ = linear_.p();
  apart_ = limits_.apart(here().q, step_);
  if (!apart_) {
    limits_.look(here().q);
    apart_ = limits_.apart(here().q, step_);
  }
  while (!apart_ && limits_.engage(step_)) {
    assemble(lambda);
    VecQ lower = lower_ - here().q, upper = upper_ - here().q, root = metric_root_;
    limits_.turn(linear_, lower, upper, root);
    linear_.solve(lower, upper, root);
    step_ = linear_.p();
    limits_.turn_back(step_);
  }
  put_trial(1.0);
  return (trial().q - here().q).cwiseAbs().cwiseQuotient(upper_ - lower_).maxCoeff();
}

void ProxySolver::put_trial(double share) noexcept {
  trial().q = (here().q + share * step_).cwiseMax(lower_).cwiseMin(upper_);
  trial().inside = apart_ || limits_.restore(trial().q);
}

/// Takes the share of the step that the cost at both ends, and its slope here, say is right; near
/// the end, when costs are rounding, the share of the last step. A share far beyond 1 is not due to
/// curvature: there a bound ended the step.
void ProxySolver::follow_curvature(const VecX& x, double promise, bool flat) noexcept {
  if (!flat) {
    double squares = 0.0;  // of what the step does to the residual
    for (Eigen::Index i = 0; i < here().r.size(); ++i) {
      const double change = here().J.row(i).dot(step_);
      squares += change * change;
    }
    if (has_prior_) squares += model_.prior_cost(prior_weight_, step_);
    const double slope = 0.5 * (promise + squares);
    const double share = slope / (trial().cost - here().cost + 2.0 * slope);
    share_ = share > kMostShare || !(share > 0.0) ? 1.0 : std::max(share, kLeastShare);
  }
  if (std::abs(share_ - 1.0) < kSameShare) return;
  put_trial(share_);
  evaluate(x, trial());
}

ProxySolver::Step ProxySolver::step(const VecX& x) noexcept {
  const double length = propose(0.0);
  const double promise = here().cost - linear_.residual2();
  limited_ = linear_.limited();
  condition_ = linear_.condition();
  rank_ = linear_.status();
  evaluate(x, trial());
  const bool flat = promise <= kLeastPromise * here().cost + floor_;
  if (!apart_ && limits_.engaged()) follow_curvature(x, promise, flat);
  const bool better =
      flat ? std::isfinite(trial().cost) && length < length_ : trial().cost <= here().cost;
  length_ = length;
  if (better) here_ = 1 - here_;
  if (length < model_.iteration().tolerance || (flat && !better)) return Step::kConverged;
  return better ? Step::kTaken : damped_step(x);
}

ProxySolver::Step ProxySolver::damped_step(const VecX& x) noexcept {
  for (int trials = 0; trials < kMaxTrials; ++trials) {
    propose(lambda_);
    evaluate(x, trial());
    if (trial().cost < here().cost) {
      here_ = 1 - here_;
      lambda_ *= kLower;
      return Step::kTaken;
    }
    lambda_ *= kRaise;
  }
  return Step::kStuck;
}

double ProxySolver::span2() noexcept {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < lower_.size(); ++k) {
    const double width = upper_[k] - lower_[k];
    sum += here().J.col(k).squaredNorm() * width * width;
  }
  return sum;
}

ProjectionStatus ProxySolver::judge(Step last) noexcept {
  if (rank_ != ProjectionStatus::kExact) return rank_;
  if (last != Step::kConverged) return ProjectionStatus::kCapped;
  const bool out_of_reach = limited_ && here().task > kNoResidual * kNoResidual * span2();
  return out_of_reach ? ProjectionStatus::kUnreachable : ProjectionStatus::kConverged;
}

}  // namespace haptic::core
