// Eq. (39): the distance between two solutions of the proxy's problem whose contacts differ by
// what a sample leaves open (core/METHOD.md#error-bound).
#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic/core/contacts/plane_projection.hpp"

namespace haptic::core {

namespace {

/// Gap errors of several rigid contacts whose gradients are 30 degrees apart or more.
constexpr double kWedge = 2.0;

}  // namespace

void PlaneProjection::begin_error(const PlaneSet& planes) noexcept {
  anchored_ = false;
  // An object's own law may be wrong in ways that no uncertainty of a stiffness tells.
  bounded_ = planes.uncertainty.size() > 0 && !laws_.any();
  if (!bounded_) return;
  uncertainty_.head(count_) = planes.uncertainty;
  unshifted_.head(count_) = beta_.head(count_);
  told_l_.setZero();
  unsettled_ = 0.0;
  exact_ = curved_ == 0 && !moving_ && planes.uncertainty.isZero(0.0);
  bend_.head(count_).setZero();
  for (int i = 0; i < count_; ++i) {
    bounded_ = bounded_ && uncertainty_[i] >= 0.0;
    if (!ContactDual::has(curved_, i)) continue;
    bend_[i] = bend(i);
    round_[static_cast<std::size_t>(i)] = round_gap(planes, i);
  }
}

double PlaneProjection::unsettled(const VecX& moved) const noexcept {
  VecX scratch;
  return metric_.weighed(moved, scratch).norm();
}

double PlaneProjection::shifted(int i) const noexcept {
  return std::abs((ContactDual::has(curved_, i) ? told_beta_[i] : beta_[i]) - unshifted_[i]);
}

void PlaneProjection::error(double age_error, ProxyError& out) const noexcept {
  out.known = bounded_ && anchored_;
  out.along = -1;
  for (PlaneSet::Offsets* each : {&out.of, &out.depth, &out.turn}) each->resize(0);
  out.everywhere = unexplained_;
  out.beside = 0;
  if (!out.known) return;
  Remainder left[kMaxPlanes];
  if (!exact_ && !proxy_error(age_error, true, left, out)) {
    static_cast<void>(proxy_error(age_error, false, left, out));
  }
  if (dual_.held() != 0) contact_errors(age_error, left, out);
}

/// `moved` is how far x and what is linearised there may be from the simulation's.
void PlaneProjection::contact_errors(double age_error, const Remainder* left,
                                     ProxyError& out) const noexcept {
  const double moved = out.everywhere + (out.of.size() > 0 ? out.of.sum() : 0.0) + unsettled_;
  const double way = dual_.l().head(count_).sum() + unsettled_;  // from the probe, or more
  out.depth.resize(count_);
  if (curved_ != 0) out.turn.setZero(count_);
  double most = 0.0;
  for (int i = 0; i < count_; ++i) {
    const bool skipped = ContactDual::has(skipped_, i);
    double depth = skipped ? 0.0 : scale_[i] * shifted(i) + std::abs(speed_[i]) * age_error;
    if (ContactDual::has(curved_, i)) {
      const double bend = scale_[i] * left[i].bend_within(moved);
      const double tilt = bend * moved + scale_[i] * left[i].gradient;
      depth += scale_[i] * left[i].gap + tilt * way + 0.5 * bend * moved * moved;
      depth = tilt < kMostBent ? (depth + tilt * std::abs(contacts_.depth[i])) / (1.0 - tilt)
                               : std::numeric_limits<double>::infinity();
      out.turn[i] = std::min(2.0, tilt / (1.0 - 0.5 * std::min(1.0, tilt)));
      most = std::max(most, out.turn[i]);
    }
    out.depth[i] = depth;
    most = std::max(most, depth);
    if (dual_.l()[i] == 0.0 && contacts_.depth[i] + depth > 0.0) out.beside |= 1u << i;
  }
  if (most >= ProxyError::kNothing) return;
  out.depth.resize(0);
  out.turn.resize(0);
}

bool PlaneProjection::proxy_error(double age_error, bool whole, Remainder* left,
                                  ProxyError& out) const noexcept {
  out.of.setZero(count_);
  out.everywhere = unexplained_;
  const Open open = what_is_open(age_error, whole, left);
  if (open.involved == 0) return true;
  out.known = open.bent < kMostBent;
  const double stays = std::max(1.0 - open.bent, 1.0 - kMostBent);
  // Each linearisation shrinks what is left by `bent`, or more.
  if (curved_ != 0) out.everywhere += unsettled_ * open.bent / stays;
  if (of_one_flat_contact(open, out)) return true;
  double as_gap[kMaxPlanes];
  const double off = of_each_contact(open, left, as_gap, out);
  return grow(open, off, whole, left, as_gap, out);
}

/// Compares each contact's force now with its force at the anchor and the one that was told.
PlaneProjection::Open PlaneProjection::what_is_open(double age_error, bool whole,
                                                    Remainder* left) const noexcept {
  Open open;
  const Vector& l = dual_.l();
  int at_anchor = 0;
  LastTurn last;
  for (int i = 0; i < count_; ++i) at_anchor += anchored_l_[i] > 0.0 || told_l_[i] > 0.0;
  for (int i = 0; i < count_; ++i) {
    double &slope = open.slope[i], &share = open.share[i], &gap = open.gap[i], &room = open.room[i];
    slope = share = gap = room = 0.0;
    if (ContactDual::has(skipped_, i)) continue;
    const double u = uncertainty_[i];
    const double before = scale_[i] > 0.0 ? anchored_l_[i] / scale_[i] : anchored_l_[i];
    slope = u * std::abs(l[i] - before);
    // Told as not touched, yet it must explain x: nothing is known of when it ends.
    if (before > 0.0 && told_l_[i] == 0.0) share = std::abs(l[i] - before) + before;
    if (at_anchor > 1 && std::max(before, told_l_[i]) > 0.0) {
      // Several contacts may share what the anchor explains in another way: felt where one lifts.
      const double shared = std::abs(before - told_l_[i]) + u * told_l_[i];
      share += l[i] > 0.0 ? std::max(0.0, shared + slope - l[i]) : 2.0 * shared;
    }
    if (ContactDual::has(curved_, i)) {
      left[i] = remainder(i, whole ? &last : nullptr);
      gap = scale_[i] * left[i].gap;
      share += scale_[i] * l[i] * left[i].gradient;
      open.bent += scale_[i] * l[i] * (left[i].whole ? left[i].bend : bend_[i]);
    }
    gap += std::abs(speed_[i]) * age_error;
    if (l[i] == 0.0) {
      room = -contacts_.depth[i];
      for (int j = 0; j < count_; ++j) {
        if (l[j] > 0.0) room += l[j] * A_.col(i).dot(contacts_.into.col(j));
      }
      room = std::max(0.0, room);
    }
    if (l[i] > 0.0 || slope > 0.0 || share > 0.0 || gap > room) {
      ++open.involved;
      open.only = i;
    }
  }
  return open;
}

/// Exact, and x is off along its normal alone. False: there are others, or it is curved.
bool PlaneProjection::of_one_flat_contact(const Open& open, ProxyError& out) const noexcept {
  const int only = open.only;
  if (open.involved != 1 || open.bent != 0.0 || ContactDual::has(curved_, only)) return false;
  const double u = uncertainty_[only], m = std::min(u, 1.0), gamma = gamma_[only];
  const double softer = gamma > 0.0 ? gamma / (1.0 - m + gamma) : 0.0;
  const double stiffer = gamma / (1.0 + u + gamma);
  const double by_slope = open.share[only] + open.slope[only] * std::max(softer, stiffer);
  const double by_gap = std::max(0.0, open.gap[only] - open.room[only]) / (1.0 + gamma / (1.0 + u));
  out.of[only] = by_slope + by_gap;
  out.along = only;
  for (int i = 0; i < count_; ++i) {
    if (i != only && !ContactDual::has(skipped_, i) && open.room[i] < out.of[only]) out.along = -1;
  }
  return out.along >= 0;
}

/// Their sum. `as_gap`: how far x is off per error of a gap.
double PlaneProjection::of_each_contact(const Open& open, const Remainder* left, double* as_gap,
                                        ProxyError& out) const noexcept {
  double off = 0.0;
  for (int i = 0; i < count_; ++i) {
    const bool curved = ContactDual::has(curved_, i);
    if (!curved && open.slope[i] + open.share[i] + open.gap[i] == 0.0) continue;
    const double u = uncertainty_[i], gamma = gamma_[i];
    const double as_force = u < 1.0 ? std::min(1.0, 0.5 * std::sqrt(gamma / (1.0 - u))) : 1.0;
    const double most = open.involved == 1 ? 1.0 : kWedge;
    as_gap[i] = gamma > 0.0 ? std::min(most, 0.5 * std::sqrt((1.0 + u) / gamma)) : most;
    // Its true gradient may be shorter: the same gap is then a longer way.
    if (curved) as_gap[i] /= std::max(1.0 - scale_[i] * left[i].gradient, 1.0 - kMostBent);
    const double by_gap = std::max(0.0, open.gap[i] - open.room[i]) * as_gap[i];
    out.of[i] = open.share[i] + open.slope[i] * as_force + by_gap;
    off += out.of[i];
  }
  return off;
}

/// On a way E forces turn and gaps bend: E <= off + bent E + c E^2. What c is on the whole way is
/// known for one that is assumed, the more the longer; it holds if E is no longer. At twice what
/// it is without c there is no root beyond. False: none holds.
bool PlaneProjection::grow(const Open& open, double off, bool whole, const Remainder* left,
                           const double* as_gap, ProxyError& out) const noexcept {
  const double stays = std::max(1.0 - open.bent, 1.0 - kMostBent);
  for (const double times : {1.25, 2.0}) {
    const double most = times * off / stays, far = most + out.everywhere + unsettled_;
    double c = 0.0;
    bool follows = true;
    for (int i = 0; i < count_ && whole; ++i) {
      if (!ContactDual::has(curved_, i) || !left[i].whole) continue;
      follows = follows && left[i].grows * far <= 1.0;
      const double bow = 0.5 * scale_[i] * left[i].bend_within(far);
      c += 0.5 * scale_[i] * dual_.l()[i] * left[i].third_within(far);
      if (open.gap[i] + bow * most * most > open.room[i]) c += bow * as_gap[i];
    }
    const double root = stays * stays - 4.0 * c * off;
    if (!follows || root < 0.0) return false;
    const double grown = 2.0 / (stays + std::sqrt(root));
    if (grown * off > most) continue;
    out.of *= grown;
    return true;
  }
  return false;
}

}  // namespace haptic::core
