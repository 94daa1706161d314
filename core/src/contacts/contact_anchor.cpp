// Eq. (37): the told gaps are shifted so that the law gives the simulation's own proxy at the probe
// that it was computed from (core/METHOD.md#contacts).
#include <algorithm>
#include <cmath>

#include "haptic/core/contacts/plane_projection.hpp"

namespace haptic::core {

namespace {

/// Weight of the multipliers' distance to those of the told law, relative to what the anchor must
/// explain: planes within a quarter of a degree of each other do not explain what is across them.
constexpr double kNearest = 1e-5;
/// Share of the gap of a contact that this law does not touch: more must be unexplained without it.
constexpr double kUntouched = 1e-2;
constexpr double kNegligible = 1.0;
constexpr int kProximal = 3;
/// Share of d that another choice of multipliers must explain more.
constexpr double kMore = 1e-2;

}  // namespace

/// Takes the way to explain d that is nearest to the law as it was told, or, if that explains less,
/// the one nearest to none. Each is tried at x_used before it is believed: if x is then further
/// from the client's own proxy than the probe is, the contacts explain nothing. Nothing explains a
/// d of 0 either: a proxy that is free stays so.
void PlaneProjection::anchor(const VecX& x_used) noexcept {
  space_->difference(x_used, at_, y_);
  if (!y_.allFinite()) return;
  const VecX d = y_;
  const Vector told_beta = beta_;
  const double length = metric_.weighed(d, turn_).norm();
  Vector l = Vector::Zero();
  unexplained_ = length;
  bool shifted = false;  // by l
  if (length > ProxyError::kNothing) {
    Vector told = Vector::Zero(), other;
    for (int i = 0; i < count_; ++i) {
      if (!(gamma_[i] > 0.0)) continue;
      told[i] = std::max(0.0, -beta_[i]) / std::max(gamma_[i], ContactDual::kEpsilon);
    }
    dual_.begin_at(told);
    static_cast<void>(solve(0.0));
    told = dual_.l();
    for (int i = 0; i < count_; ++i) {  // x_0, where its depth is told, is that near
      const double deepest = std::max(0.0, -beta_[i]) + length;
      told[i] = std::min(told[i], deepest / std::max(gamma_[i], ContactDual::kEpsilon));
    }
    explain(d, told, l);
    unexplained_ = shift(d, l, told_beta);
    shifted = true;
    if (unexplained_ > kMore * length) {
      beta_ = told_beta;
      explain(d, Vector::Zero(), other);
      const double left = shift(d, other, told_beta);
      shifted = left + kMore * length < unexplained_;
      if (shifted) {
        unexplained_ = left;
        l = other;
      }
    }
    if (dual_.left() == 0) {
      leave_as_told(told_beta);
      unexplained_ = length;
      return;
    }
    if (!(unexplained_ <= length)) {
      unexplained_ = length;
      l.setZero();
      shifted = false;
    }
  }
  if (!shifted) static_cast<void>(shift(d, l, told_beta));
  for (int i = 0; i < count_; ++i) {
    told_l_[i] = gamma_[i] > 0.0 ? std::max(0.0, -told_beta[i]) / gamma_[i] : l[i];
    exact_ = exact_ &&
             (ContactDual::has(skipped_, i) || std::abs(told_l_[i] - l[i]) < ProxyError::kNothing);
  }
  anchored_ = true;
  explained_ = unexplained_ <= kMore * length;
  anchored_l_ = l;
}

/// The work that a sample may cost is spent: what was cut off decides nothing.
void PlaneProjection::leave_as_told(const Vector& told_beta) noexcept {
  beta_ = told_beta;
  for (int i = 0; i < count_; ++i) fill_diagonal(i);
  dual_.leave_out(skipped_);
}

/// Shifts the gaps so that l explains d, and returns how far that leaves x from the client's own.
double PlaneProjection::shift(const VecX& d, const Vector& l, const Vector& told_beta) noexcept {
  VecX left = d;
  bool rigid = false;
  for (int i = 0; i < count_; ++i) {
    if (l[i] == 0.0) continue;
    push(left, -l[i], i);
    rigid = rigid || gamma_[i] == 0.0;
  }
  for (int i = 0; i < count_; ++i) {
    if (ContactDual::has(skipped_, i)) continue;
    const double met = along(i, left.data()) - gamma_[i] * l[i];
    beta_[i] = l[i] > 0.0 ? met : std::max(told_beta[i], met);
    fill_diagonal(i);
  }
  dual_.leave_out(skipped_);
  y_ = d;
  if (rigid) {
    static_cast<void>(solve(0.0));
    left = d;
    for (int i = 0; i < count_; ++i) {
      if (ContactDual::has(dual_.held(), i)) push(left, -dual_.l()[i], i);
    }
  } else {
    dual_.begin_at(l);  // which is the answer
  }
  return metric_.weighed(left, turn_).norm();
}

/// min ||d - D l||_W^2 over l >= 0. Among what explains it equally well the l nearest to `told`;
/// and a contact that this law does not touch enters only if d needs it, because its whole gap
/// would be shifted.
void PlaneProjection::explain(const VecX& d, const Vector& told, Vector& l) noexcept {
  VecX left = d;
  for (int i = 0; i < count_; ++i) {
    if (told[i] != 0.0) push(left, -told[i], i);
  }
  Vector r = Vector::Zero();
  for (int i = 0; i < count_; ++i) {
    const double gap = told[i] > 0.0 ? 0.0 : std::max(0.0, beta_[i] - along(i, left.data()));
    r[i] = ContactDual::has(skipped_, i)
               ? -1.0
               : along(i, d.data()) + kNearest * told[i] - kUntouched * gap;
    dual_.put_diagonal(i, dual_.products()(i, i) + kNearest);
  }
  dual_.leave_out(skipped_);
  dual_.solve(r);
  // Those that entered explain d whole.
  const std::uint32_t entered = dual_.held();
  dual_.leave_out(~entered);
  l = told;
  for (int n = 0; n < kProximal; ++n) {
    for (int i = 0; i < count_; ++i) {
      if (ContactDual::has(entered, i)) r[i] = along(i, d.data()) + kNearest * l[i];
    }
    dual_.solve(r);
    l = dual_.l();
  }
  // Drops what the told law alone wants: a proxy that is free stays so.
  for (int i = 0; i < count_; ++i) {
    if (l[i] <= kNegligible * kNearest * told[i]) l[i] = 0.0;
  }
}

}  // namespace haptic::core
