#include "haptic/core/contacts/contact_solver.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace haptic::core {

namespace {

/// Curved gaps are linearised again only if x moved by more, m or rad.
constexpr double kSameX = 1e-9;
/// A step towards x that leaves more than this share of the one before is halved from there on.
constexpr double kShrinks = 0.9;
/// A step longer than so many times what the probe and the surfaces moved is not due to them.
constexpr double kTheirs = 10.0;

}  // namespace

void ContactSolver::begin() noexcept {
  const int count = gaps_.size();
  fresh_ = true;
  linearisations_ = 0;
  dual_.allow(kMostWork);
  dual_.begin(count, gaps_.left_out());
  std::fill_n(dual_.products().data(), count * kMaxPlanes, 0.0);
  gaps_.multiply(~0u, dual_.products());
  fill();
  damped_ = 1.0;
  unsettled_ = 0.0;
  for (VecX* each : {&z_, &at_, &y_before_}) each->setZero(gaps_.space().n_x());
}

void ContactSolver::fill() noexcept {
  if (laws_.any()) {
    const ContactDual::Gives gives = laws_.gives(gaps_.scale());
    dual_.give(&gives);
  } else {
    dual_.give(nullptr);
  }
  for (int i = 0; i < gaps_.size(); ++i) fill(i);
}

void ContactSolver::fill(int i) noexcept {
  const double scale = gaps_.scale()[i];
  const double gives = laws_.any() ? laws_.give(i) * scale * scale : 0.0;
  dual_.set_diagonal(i, dual_.products()(i, i), gaps_.gamma()[i] + gives);
}

PlaneStatus ContactSolver::solve(const VecX& y, double age) noexcept {
  Vector r;  // as many as there are contacts
  const double deepest = gaps_.violations(y, age, laws_, r);
  if (!(deepest > 0.0)) {
    dual_.hold_none();
    return PlaneStatus::kFree;
  }
  return dual_.meet(r, deepest) ? PlaneStatus::kActive : PlaneStatus::kInfeasible;
}

PlaneStatus ContactSolver::project(const VecX& y, double age, int most_steps) noexcept {
  if (most_steps > 1) dual_.allow(kMostWork + (fresh_ ? dual_.left() : 0));
  const PlaneStatus status = gaps_.curved() == 0 ? solve(y, age) : settle(y, age, most_steps);
  fresh_ = false;
  return status;
}

/// z_ goes towards the x of the gaps that are linearised there. If that does not come nearer,
/// although neither probe nor surfaces moved, it goes half as far from there on: so the steps of a
/// probe at rest have a finite sum.
PlaneStatus ContactSolver::settle(const VecX& y, double age, int most_steps) noexcept {
  const int count = gaps_.size();
  double moved = laws_.any() ? HUGE_VAL : (y - y_before_).lpNorm<Eigen::Infinity>();
  for (int i = 0; gaps_.moving() && i < count; ++i) {
    moved = std::max(moved, std::abs(gaps_.speed()[i] * (age - age_before_)));
  }
  y_before_ = y;
  age_before_ = age;
  VecX scratch;
  PlaneStatus status = PlaneStatus::kFree;
  const int steps =
      std::clamp(kMostEntries / PlaneSet::triangle(count), 1, fresh_ ? kFirstSteps : most_steps);
  for (linearisations_ = 0; linearisations_ < steps;) {
    const bool first = linearisations_++ == 0;
    if (!(fresh_ && first)) {
      gaps_.linearise(z_);
      gaps_.multiply(gaps_.curved(), dual_.products());
    }
    fill();
    status = solve(y, age);
    step_ = y - z_;
    for (std::uint32_t left = held(); left != 0; left &= left - 1) {
      const int i = std::countr_zero(left);
      gaps_.push(step_, -l()[i], i);
    }
    if (!step_.allFinite()) continue;
    const double step = step_.lpNorm<Eigen::Infinity>();
    damp(step, first && (fresh_ || step <= kTheirs * moved));
    at_ = z_ + step_;
    z_ += damped_ * step_;
    if (step < kSameX) break;
  }
  if (step_.allFinite()) unsettled_ = gaps_.metric().weighed(step_, scratch).norm();
  return status;
}

void ContactSolver::damp(double step, bool theirs) noexcept {
  if (theirs) {
    damped_ = std::min(1.0, 2.0 * damped_);
  } else if (step > kShrinks * step_before_) {
    damped_ *= 0.5;
  }
  step_before_ = step;
}

}  // namespace haptic::core
