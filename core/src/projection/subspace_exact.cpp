#include "haptic/core/projection/subspace_exact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic::core {

SubspaceExact::SubspaceExact(const Kinematics& kinematics)
    : kinematics_(&kinematics), solver_(kinematics.space().n_x(), kinematics.layout()) {
  const int n_q = kinematics.layout().n_q();
  const int n_x = kinematics.space().n_x();
  lower_.resize(n_q);
  upper_.resize(n_q);
  for (int i = 0; i < n_q; ++i) {
    lower_[i] = kinematics.dofs()[static_cast<std::size_t>(i)].lower;
    upper_[i] = kinematics.dofs()[static_cast<std::size_t>(i)].upper;
  }
  q_ = trial_ = step_ = VecQ::Zero(n_q);
  x_at_ = r_ = rhs_ = VecX::Zero(n_x);
  J_ = J_free_ = MatXQ::Zero(n_x, n_q);
}

void SubspaceExact::project(const Probe& probe, const VecX& x, const VecA& stiffness,
                            bool proxy_changed, Projection& out) noexcept {
  if (proxy_changed || !has_solution_) {
    const InverseStatus inverse = kinematics_->inverse(x, solution_.q_star);
    if (inverse == InverseStatus::kNotOffered) {
      q_ = has_solution_ ? solution_.q_star : probe.q;
      iterate(x, stiffness);
    } else {
      const double cost = cost_at(solution_.q_star, x);
      solution_.status = inverse == InverseStatus::kExact ? ProjectionStatus::kExact
                                                          : ProjectionStatus::kUnreachable;
      solution_.residual = std::sqrt(cost);
      solution_.condition = 0.0;
    }
    has_solution_ = true;
  }
  out = solution_;
}

double SubspaceExact::cost_at(const VecQ& q, const VecX& x) noexcept {
  if (kinematics_->evaluate(q, x_at_, J_) != MapStatus::kOk) {
    return std::numeric_limits<double>::infinity();
  }
  kinematics_->space().difference(x, x_at_, r_);
  return r_.squaredNorm();
}

void SubspaceExact::iterate(const VecX& x, const VecA& stiffness) noexcept {
  q_ = q_.cwiseMax(lower_).cwiseMin(upper_);
  double cost = cost_at(q_, x);
  solution_.status = ProjectionStatus::kCapped;
  for (int i = 0; i < kMaxSteps && std::isfinite(cost); ++i) {
    box_step(stiffness);
    bool accepted = false;
    double length = 0.0;
    for (int h = 0; h <= kMaxHalvings && !accepted; ++h) {
      trial_ = (q_ + step_).cwiseMax(lower_).cwiseMin(upper_);
      const double trial_cost = cost_at(trial_, x);
      if (trial_cost <= cost) {
        length = ((trial_ - q_).cwiseAbs().cwiseQuotient(upper_ - lower_)).maxCoeff();
        q_ = trial_;
        cost = trial_cost;
        accepted = true;
      } else {
        step_ *= 0.5;
      }
    }
    if (!accepted) cost = cost_at(q_, x);  // r_ and J_ back to the best iterate
    if (!accepted || length < kTolerance) {
      solution_.status = ProjectionStatus::kConverged;
      break;
    }
  }
  solution_.q_star = q_;
  solution_.residual = std::isfinite(cost) ? std::sqrt(cost) : 0.0;
  solution_.condition = solver_.condition();
  if (!std::isfinite(cost)) {
    solution_.status = ProjectionStatus::kMapFailed;
  } else if (solver_.status() != ProjectionStatus::kExact) {
    solution_.status = solver_.status();
  }
}

void SubspaceExact::box_step(const VecA& stiffness) noexcept {
  const int n_q = kinematics_->layout().n_q();
  bool fixed[kMaxQ]{};
  bool released[kMaxQ]{};
  step_.setZero(n_q);
  for (int pass = 0; pass < 2 * n_q; ++pass) {
    // Fixed coordinates keep their step; the free ones solve for what is left.
    J_free_ = J_;
    rhs_ = r_;
    for (int i = 0; i < n_q; ++i) {
      if (!fixed[i]) continue;
      rhs_ -= step_[i] * J_.col(i);
      J_free_.col(i).setZero();
    }
    solver_.solve(J_free_, rhs_, stiffness);
    int worst = -1;
    double worst_excess = 0.0;
    for (int i = 0; i < n_q; ++i) {
      if (fixed[i]) continue;
      step_[i] = solver_.dq()[i];
      const double target = q_[i] + step_[i];
      const double excess =
          std::max(lower_[i] - target, target - upper_[i]) / (upper_[i] - lower_[i]);
      if (excess > worst_excess) {
        worst_excess = excess;
        worst = i;
      }
    }
    if (worst >= 0) {
      fixed[worst] = true;
      step_[worst] =
          (q_[worst] + step_[worst] > upper_[worst] ? upper_[worst] : lower_[worst]) - q_[worst];
      continue;
    }
    // All free ones are inside: let go of a limit that the residual pulls away from, once each.
    rhs_ = r_;
    rhs_ -= J_.lazyProduct(step_);
    int wrong = -1;
    for (int i = 0; i < n_q && wrong < 0; ++i) {
      if (!fixed[i] || released[i]) continue;
      const double pull = J_.col(i).dot(rhs_);  // > 0: the cost falls with a larger q_i
      const bool at_upper = q_[i] + step_[i] >= upper_[i];
      if ((at_upper && pull < 0.0) || (!at_upper && pull > 0.0)) wrong = i;
    }
    if (wrong < 0) return;
    fixed[wrong] = false;
    released[wrong] = true;
  }
}

}  // namespace haptic::core
