#include "haptic/core/contacts/contact_anchor.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "haptic/core/contacts/proxy_error.hpp"

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

void ContactAnchor::set(const VecX& d) noexcept {
  if (!d.allFinite()) return;
  told_beta_ = gaps_.beta();
  VecX scratch;
  const double length = gaps_.metric().weighed(d, scratch).norm();
  unexplained_ = length;
  l_.setZero();
  if (!(length > ProxyError::kNothing)) {
    static_cast<void>(shift(d, l_));
  } else if (!choose(d, length)) {
    leave_as_told();
    unexplained_ = length;
    return;
  }
  known_ = as_told_ = true;
  explained_ = unexplained_ <= kMore * length;
  for (int i = 0; i < gaps_.size(); ++i) {
    const double gamma = gaps_.gamma()[i];
    told_l_[i] = gamma > 0.0 ? std::max(0.0, -told_beta_[i]) / gamma : l_[i];
    shift_[i] = std::abs(gaps_.beta()[i] - told_beta_[i]);
    as_told_ =
        as_told_ && (gaps_.leaves_out(i) || std::abs(told_l_[i] - l_[i]) < ProxyError::kNothing);
  }
}

/// Takes the way to explain d that is nearest to the law as it was told, or, if that explains less,
/// the one nearest to none. Each is tried at d before it is believed: if x is then further from the
/// simulation's own proxy than the probe is, the contacts explain nothing. Nothing explains a d of
/// 0 either: a proxy that is free stays so.
bool ContactAnchor::choose(const VecX& d, double length) noexcept {
  find_told(d, length);
  explain(d, told_l_, l_);
  unexplained_ = shift(d, l_);
  bool shifted = true;  // by l_
  if (unexplained_ > kMore * length) {
    for (int i = 0; i < gaps_.size(); ++i) gaps_.shift(i, told_beta_[i]);
    Vector other;
    explain(d, Vector::Zero(), other);
    const double left = shift(d, other);
    shifted = left + kMore * length < unexplained_;
    if (shifted) {
      unexplained_ = left;
      l_ = other;
    }
  }
  if (solver_.dual().left() == 0) return false;
  if (!(unexplained_ <= length)) {
    unexplained_ = length;
    l_.setZero();
    shifted = false;
  }
  if (!shifted) static_cast<void>(shift(d, l_));
  return true;
}

void ContactAnchor::find_told(const VecX& d, double length) noexcept {
  const Vector &beta = gaps_.beta(), &gamma = gaps_.gamma();
  told_l_.setZero();
  for (int i = 0; i < gaps_.size(); ++i) {
    if (!(gamma[i] > 0.0)) continue;
    told_l_[i] = std::max(0.0, -beta[i]) / std::max(gamma[i], ContactDual::kEpsilon);
  }
  solver_.dual().begin_at(told_l_);
  static_cast<void>(solver_.solve(d, 0.0));
  for (int i = 0; i < gaps_.size(); ++i) {  // y = 0, if its depth is told, is that near
    const double deepest = std::max(0.0, -beta[i]) + length;
    told_l_[i] = std::min(solver_.l()[i], deepest / std::max(gamma[i], ContactDual::kEpsilon));
  }
}

/// The work that a sample may cost is spent: what was cut off decides nothing.
void ContactAnchor::leave_as_told() noexcept {
  for (int i = 0; i < gaps_.size(); ++i) {
    gaps_.shift(i, told_beta_[i]);
    solver_.fill(i);
  }
  solver_.dual().leave_out(gaps_.left_out());
}

double ContactAnchor::shift(const VecX& d, const Vector& l) noexcept {
  const Vector& gamma = gaps_.gamma();
  VecX left = d;
  bool rigid = false;
  for (int i = 0; i < gaps_.size(); ++i) {
    if (l[i] == 0.0) continue;
    gaps_.push(left, -l[i], i);
    rigid = rigid || gamma[i] == 0.0;
  }
  for (int i = 0; i < gaps_.size(); ++i) {
    if (gaps_.leaves_out(i)) continue;
    const double met = gaps_.along(i, left.data()) - gamma[i] * l[i];
    gaps_.shift(i, l[i] > 0.0 ? met : std::max(told_beta_[i], met));
    solver_.fill(i);
  }
  solver_.dual().leave_out(gaps_.left_out());
  if (rigid) {
    static_cast<void>(solver_.solve(d, 0.0));
    left = d;
    for (std::uint32_t held = solver_.held(); held != 0; held &= held - 1) {
      const int i = std::countr_zero(held);
      gaps_.push(left, -solver_.l()[i], i);
    }
  } else {
    solver_.dual().begin_at(l);  // which is the answer
  }
  VecX scratch;
  return gaps_.metric().weighed(left, scratch).norm();
}

/// min ||d - D l||_W^2 over l >= 0. Among what explains it equally well the l nearest to `told`;
/// and a contact that this law does not touch enters only if d needs it, because its whole gap
/// would be shifted.
void ContactAnchor::explain(const VecX& d, const Vector& told, Vector& l) noexcept {
  ContactDual& dual = solver_.dual();
  const int count = gaps_.size();
  VecX left = d;
  for (int i = 0; i < count; ++i) {
    if (told[i] != 0.0) gaps_.push(left, -told[i], i);
  }
  Vector r = Vector::Zero();
  for (int i = 0; i < count; ++i) {
    const double gap =
        told[i] > 0.0 ? 0.0 : std::max(0.0, gaps_.beta()[i] - gaps_.along(i, left.data()));
    r[i] = gaps_.leaves_out(i) ? -1.0
                               : gaps_.along(i, d.data()) + kNearest * told[i] - kUntouched * gap;
    dual.put_diagonal(i, dual.products()(i, i) + kNearest);
  }
  dual.leave_out(gaps_.left_out());
  dual.solve(r);
  // Those that entered explain d whole.
  const std::uint32_t entered = dual.held();
  dual.leave_out(~entered);
  l = told;
  for (int n = 0; n < kProximal; ++n) {
    for (int i = 0; i < count; ++i) {
      if (ContactDual::has(entered, i)) r[i] = gaps_.along(i, d.data()) + kNearest * l[i];
    }
    dual.solve(r);
    l = dual.l();
  }
  // Drops what the told law alone wants: a proxy that is free stays so.
  for (int i = 0; i < count; ++i) {
    if (l[i] <= kNegligible * kNearest * told[i]) l[i] = 0.0;
  }
}

}  // namespace haptic::core
