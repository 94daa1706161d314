// Eqs. (27) and (36) by their dual: an unknown per contact, whatever n_x is. r holds the violations
// of the probe, G = A W^-1 A^T with unit gradients, Gamma = diag(gamma), and x = x_probe - W^-1 A^T
// l. A contact's own violation is then gamma l.
#include "haptic/core/contacts/plane_projection.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace haptic::core {

namespace {

/// Curved gaps are linearised again only if x moved by more, m or rad.
constexpr double kSameX = 1e-9;
/// A step towards x that leaves more than this share of the one before is halved from there on.
constexpr double kShrinks = 0.9;
/// Beyond so many times what the probe and the surfaces moved a step is not theirs.
constexpr double kTheirs = 10.0;
/// Times of a replay, and of a step with n contacts, measured: a + b n + c n^2, flat and curved.
constexpr double kReplay_ns = 16000.0;
constexpr double kFlat_ns[] = {25.0, 25.0, 5.0}, kCurved_ns[] = {20.0, 110.0, 15.0};

}  // namespace

PlaneProjection::PlaneProjection(const ConfigurationSpace& space, TaskMetric metric)
    : space_(&space), metric_(std::move(metric)), at_(VecX::Zero(space.n_x())) {
  for (const Coordinate& c : space.coordinates()) {
    linear_.push_back(c.kind == CoordinateKind::kLinear);
  }
}

void PlaneProjection::set(const PlaneSet& planes, const VecX& x, const VecX* x_used) noexcept {
  count_ = planes.size();
  skipped_ = curved_ = 0;
  moving_ = planes.velocity.size() > 0;
  soft_ = planes.compliance.size() > 0;
  fresh_ = true;
  begun_ = false;
  laws_.begin_sample();
  unexplained_ = 0.0;
  linearisations_ = 0;
  at_ = x;
  A_ = planes.normals;
  contacts_.into.resize(A_.rows(), count_);
  contacts_.depth.setConstant(count_, -1.0);
  dual_.allow(kMostWork);
  H_ = planes.curvature;
  first_ = planes.first;
  n_curved_ = planes.curved;
  int begin = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
    begin_[i] = begin;
    begin += PlaneSet::triangle(n_curved_[i]);
  }
  for (int i = 0; i < count_; ++i) take(planes, i);
  laws_.share(planes.objects);
  if (laws_.any()) laws_.correct_masses();
  dual_.begin(count_, skipped_);
  std::fill_n(dual_.products().data(), count_ * kMaxPlanes, 0.0);
  for (int i = 0; i < count_; ++i) {
    find_meeting(i);
    for (std::uint32_t left = meeting_[static_cast<std::size_t>(i)]; left != 0; left &= left - 1) {
      multiply(i, std::countr_zero(left));
    }
  }
  fill_gram();
  begin_error(planes);
  if (x_used != nullptr) anchor(*x_used);
  if (curved_ == 0) return;
  told_.resize(A_.rows(), count_);
  told_into_.resize(A_.rows(), count_);
  for (std::uint32_t left = curved_; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    told_.col(i) = A_.col(i);
    told_into_.col(i) = contacts_.into.col(i);
  }
  damped_ = 1.0;
  told_beta_ = beta_;
  told_gamma_ = gamma_;
  told_speed_ = speed_;
  z_.setZero(at_.size());
  turn_.setZero(at_.size());
  y_before_.setZero(at_.size());
}

bool PlaneProjection::begin_at_anchor() noexcept {
  // Where x is not the sample's own, curved gaps are linearised elsewhere, and push otherwise.
  begun_ = anchored_ && (curved_ == 0 || explained_);
  if (!begun_) return false;
  static_cast<void>(laws_.begin(0.0));
  laws_.end(dual_.l());
  return true;
}

void PlaneProjection::rewind() noexcept {
  laws_.rewind();
  laws_.compare_next();
  dual_.allow(kMostWork / 4);
}

PlaneStatus PlaneProjection::project(const VecX& x_probe, VecX& x, double age, double dt,
                                     int most_steps) noexcept {
  x = x_probe;
  if (count_ == 0) return PlaneStatus::kFree;
  if (laws_.any() && laws_.begin(begun_ ? dt : 0.0) && curved_ == 0) fill_gram();
  space_->difference(x_probe, at_, y_);
  if (most_steps > 1) dual_.allow(kMostWork + (fresh_ ? dual_.left() : 0));
  const PlaneStatus status = curved_ == 0 ? solve(age) : settle(age, most_steps);
  fresh_ = false;
  begun_ = true;
  if (laws_.any()) {
    Vector l;
    l.head(count_) = dual_.l().head(count_).cwiseProduct(scale_.head(count_));
    laws_.end(l);
  }
  displace(x);
  if (x.allFinite()) return status;
  // Numbers at the ends of what may be told, such as a normal of 1e-100: nothing follows from them.
  x = x_probe;
  dual_.hold_none();
  return PlaneStatus::kInfeasible;
}

/// z_ goes towards the x of the gaps that are linearised there. If that does not come nearer,
/// although neither probe nor surfaces moved, it goes half as far from there on: so the steps of a
/// probe at rest have a finite sum.
PlaneStatus PlaneProjection::settle(double age, int most_steps) noexcept {
  double moved = laws_.any() ? HUGE_VAL : (y_ - y_before_).lpNorm<Eigen::Infinity>();
  for (int i = 0; moving_ && i < count_; ++i) {
    moved = std::max(moved, std::abs(speed_[i] * (age - age_before_)));
  }
  y_before_ = y_;
  age_before_ = age;
  PlaneStatus status = PlaneStatus::kFree;
  const int steps = most_linearisations(fresh_ ? kFirstSteps : most_steps);
  linearisations_ = 0;
  for (int k = 0; k < steps; ++k) {
    ++linearisations_;
    if (fresh_ && k == 0) {  // at at_, as set() left them
      fill_gram();
    } else {
      linearise();
    }
    status = solve(age);
    turn_ = y_ - z_;
    for (int i = 0; i < count_; ++i) {
      if (ContactDual::has(dual_.held(), i)) push(turn_, -dual_.l()[i], i);
    }
    if (!turn_.allFinite()) continue;
    const double step = turn_.lpNorm<Eigen::Infinity>();
    const bool theirs = k == 0 && (fresh_ || step <= kTheirs * moved);
    if (theirs) {
      damped_ = std::min(1.0, 2.0 * damped_);
    } else if (step > kShrinks * step_before_) {
      damped_ *= 0.5;
    }
    step_before_ = step;
    if (bounded_) unsettled_ = unsettled(turn_);
    z_ += damped_ * turn_;
    if (step < kSameX) break;
  }
  return status;
}

int PlaneProjection::most_linearisations(int most) const noexcept {
  return std::clamp(kMostEntries / PlaneSet::triangle(count_), 1, most);
}

/// Multipliers for the probe at y_.
PlaneStatus PlaneProjection::solve(double age) noexcept {
  Vector r = Vector::Zero();
  double deepest = 0.0;
  for (int i = 0; i < count_; ++i) {
    r[i] = ContactDual::has(skipped_, i) ? -1.0 : along(i, y_.data()) - beta_[i];
    if (moving_ && !ContactDual::has(skipped_, i)) r[i] -= age * speed_[i];
    if (laws_.has(i)) r[i] -= laws_.free(i) * scale_[i];
    deepest = std::max(deepest, r[i]);
    contacts_.depth[i] = r[i];
  }
  if (!(deepest > 0.0)) {
    dual_.hold_none();
    return PlaneStatus::kFree;
  }
  return dual_.meet(r, deepest) ? PlaneStatus::kActive : PlaneStatus::kInfeasible;
}

void PlaneProjection::displace(VecX& x) const noexcept {
  if (dual_.held() == 0) return;
  const PlaneSet::Normals& D = contacts_.into;
  const std::uint32_t held = dual_.held();
  // A coordinate that no plane holds equals the probe's, to the bit: nothing is in its way.
  bool moved[kMaxX];
  for (Eigen::Index k = 0; k < x.size(); ++k) moved[k] = !linear_[static_cast<std::size_t>(k)];
  for (std::uint32_t left = held; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    const Rows rows = rows_into(i);
    for (int k = rows.first; k < rows.first + rows.count; ++k) {
      moved[k] = moved[k] || D(k, i) != 0.0;
    }
  }
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    // From at_ on, not from x_probe: an angle or a rotation there may be one turn or one sign away.
    if (moved[k]) x[k] = at_[k] + y_[k];
  }
  for (std::uint32_t left = held; left != 0; left &= left - 1) {
    push(x, -dual_.l()[std::countr_zero(left)], std::countr_zero(left));
  }
}

void PlaneProjection::push(VecX& v, double l, int i) const noexcept {
  const Rows rows = rows_into(i);
  const double* const into = contacts_.into.col(i).data();
  for (int k = rows.first; k < rows.first + rows.count; ++k) v[k] += l * into[k];
}

double PlaneProjection::stored() const noexcept {
  double sum = laws_.any() ? laws_.energy() : 0.0;
  for (int i = 0; soft_ && dual_.held() != 0 && i < count_; ++i) {
    sum += 0.5 * gamma_[i] * dual_.l()[i] * dual_.l()[i];
  }
  return sum;
}

double PlaneProjection::coupling() const noexcept {
  if (dual_.held() == 0) return 0.0;
  VecX displaced = VecX::Zero(at_.size());
  double sum = 0.0;
  for (int i = 0; i < count_; ++i) {
    if (dual_.l()[i] > 0.0) push(displaced, dual_.l()[i], i);
  }
  for (int i = 0; i < count_; ++i) sum += 0.5 * dual_.l()[i] * along(i, displaced.data());
  return sum;
}

int PlaneProjection::replayable() const noexcept {
  const double* cost = curved_ == 0 ? kFlat_ns : kCurved_ns;
  return 1 + static_cast<int>(kReplay_ns / (cost[0] + count_ * (cost[1] + count_ * cost[2])));
}

}  // namespace haptic::core
