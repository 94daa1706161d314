// Eq. (39): the distance between two solutions of the proxy's problem whose contacts differ by
// what a sample leaves open (core/METHOD.md#error-bound).
#include "haptic/core/contacts/proxy_bound.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic::core {

namespace {

constexpr double kParallel = 1e-6;  ///< 1 - cosine^2 of two rigid contacts
constexpr double kMargin = 1.01;    ///< of E: rounding

}  // namespace

void ProxyBound::set(const PlaneSet& told, bool laws) noexcept {
  told_ = told.uncertainty.size() > 0 && !laws;
  if (!told_) return;
  const int count = gaps_.size();
  uncertainty_.head(count) = told.uncertainty;
  plain_ = gaps_.curved() == 0 && !gaps_.moving() && told.uncertainty.isZero(0.0);
  bend_.head(count).setZero();
  for (int i = 0; i < count; ++i) {
    told_ = told_ && uncertainty_[i] >= 0.0;
    if (!gaps_.is_curved(i)) continue;
    // The normal turns while the body passes by, and nothing tells how fast that is.
    told_ = told_ && gaps_.speed()[i] == 0.0;
    bend_[i] = bend(i);
    round_[static_cast<std::size_t>(i)] = round_gap(told, i);
  }
}

void ProxyBound::at(double age_error, ProxyError& out) const noexcept {
  out.known = told_ && anchor_.known();
  out.along = -1;
  for (PlaneSet::Offsets* each : {&out.of, &out.depth, &out.turn}) each->resize(0);
  out.everywhere = anchor_.unexplained();
  out.beside = 0;
  if (!out.known) return;
  Remainder left[kMaxPlanes];
  if (!(plain_ && anchor_.as_told())) proxy_error(age_error, left, out);
  if (solver_.held() != 0) contact_errors(age_error, left, out);
}

/// `moved` is how far x and what is linearised there may be from the simulation's.
void ProxyBound::contact_errors(double age_error, const Remainder* left,
                                ProxyError& out) const noexcept {
  const double moved = out.everywhere + (out.of.size() > 0 ? out.of.sum() : 0.0);
  const double way = solver_.l().head(gaps_.size()).sum();  // from the probe, or more
  out.depth.resize(gaps_.size());
  if (gaps_.curved() != 0) out.turn.setZero(gaps_.size());
  const Vector &l = solver_.l(), &scale = gaps_.scale();
  const PlaneSet::Offsets& beyond = gaps_.contacts().depth;
  double most = 0.0;
  for (int i = 0; i < gaps_.size(); ++i) {
    double depth = 0.0;
    if (!gaps_.leaves_out(i)) {
      depth = scale[i] * anchor_.shift()[i] + std::abs(gaps_.speed()[i]) * age_error;
    }
    if (gaps_.is_curved(i)) {
      const double bend = scale[i] * left[i].bend_within(moved);
      const double tilt = bend * moved + scale[i] * left[i].gradient;
      depth += scale[i] * left[i].gap + tilt * way + 0.5 * bend * moved * moved;
      depth = tilt < kMostBent ? (depth + tilt * std::abs(beyond[i])) / (1.0 - tilt)
                               : std::numeric_limits<double>::infinity();
      out.turn[i] = std::min(2.0, tilt / (1.0 - 0.5 * std::min(1.0, tilt)));
      most = std::max(most, out.turn[i]);
    }
    out.depth[i] = depth;
    most = std::max(most, depth);
    if (l[i] == 0.0 && beyond[i] + depth > 0.0) out.beside |= 1u << i;
  }
  if (most >= ProxyError::kNothing) return;
  out.depth.resize(0);
  out.turn.resize(0);
}

void ProxyBound::proxy_error(double age_error, Remainder* left, ProxyError& out) const noexcept {
  out.of.setZero(gaps_.size());
  out.everywhere = anchor_.unexplained();
  Open open = what_is_open(age_error, left);
  if (open.involved == 0) return;
  out.known = open.bent < kMostPressed;
  if (of_one_flat_contact(open, out)) return;
  const double off = of_each_contact(open, left, out);
  out.known = out.known && grow(open, off, left, out) && !wedged(open) && only_minimum(open, left);
}

/// Compares each contact's force now with its force at the anchor and the one that was told.
ProxyBound::Open ProxyBound::what_is_open(double age_error, Remainder* left) const noexcept {
  Open open;
  const Vector &l = solver_.l(), &at_anchor = anchor_.l(), &told_l = anchor_.told_l();
  const Vector& scale = gaps_.scale();
  int touched = 0;
  double far = 0.0;
  LastTurn last;
  for (int i = 0; i < gaps_.size(); ++i) touched += at_anchor[i] > 0.0 || told_l[i] > 0.0;
  if (touched > 1 && gaps_.curved() != 0) {
    VecX scratch;
    far = gaps_.metric().weighed(solver_.at(), scratch).norm();
  }
  for (int i = 0; i < gaps_.size(); ++i) {
    double &slope = open.slope[i], &share = open.share[i], &gap = open.gap[i], &room = open.room[i];
    slope = share = gap = room = 0.0;
    if (gaps_.leaves_out(i)) continue;
    const double u = uncertainty_[i];
    const double before = scale[i] > 0.0 ? at_anchor[i] / scale[i] : at_anchor[i];
    slope = u * std::abs(l[i] - before);
    // Told as not touched, yet it must explain x: nothing is known of when it ends.
    if (before > 0.0 && told_l[i] == 0.0) share = std::abs(l[i] - before) + before;
    if (gaps_.is_curved(i)) left[i] = remainder(i, last);
    if (touched > 1 && std::max(before, told_l[i]) > 0.0) {
      // Several contacts may share what the anchor explains in another way: felt where one lifts,
      // or turns.
      const double shared = std::abs(before - told_l[i]) + u * told_l[i];
      share += l[i] > 0.0 ? std::max(0.0, shared + slope - l[i]) : 2.0 * shared;
      if (gaps_.is_curved(i)) share += shared * (bend_[i] * far + left[i].gradient);
    }
    if (gaps_.is_curved(i)) {
      gap = scale[i] * left[i].gap;
      share += scale[i] * l[i] * left[i].gradient;
      open.bent += scale[i] * l[i] * left[i].bend;
    }
    gap += std::abs(gaps_.speed()[i]) * age_error;
    if (l[i] == 0.0) {
      room = -gaps_.contacts().depth[i];
      for (int j = 0; j < gaps_.size(); ++j) {
        if (l[j] > 0.0) room += l[j] * gaps_.gradients().col(i).dot(gaps_.contacts().into.col(j));
      }
      room = std::max(0.0, room);
    }
    // Turned so far that nothing of its direction is left.
    const bool gone = scale[i] == 0.0;
    if (gone || l[i] > 0.0 || slope > 0.0 || share > 0.0 || gap > room) {
      const bool lost = gone || (gaps_.is_curved(i) && scale[i] * left[i].gradient > kMostBent);
      if (lost) open.bent = std::numeric_limits<double>::infinity();
      ++open.involved;
      open.other = open.only;
      open.only = i;
    }
  }
  return open;
}

/// Exact, and x is off along its normal alone. False: there are others, or it is curved.
bool ProxyBound::of_one_flat_contact(const Open& open, ProxyError& out) const noexcept {
  const int only = open.only;
  if (open.involved != 1 || open.bent != 0.0 || gaps_.is_curved(only)) return false;
  const double u = uncertainty_[only], m = std::min(u, 1.0), gamma = gaps_.gamma()[only];
  const double softer = gamma > 0.0 ? gamma / (1.0 - m + gamma) : 0.0;
  const double stiffer = gamma / (1.0 + u + gamma);
  const double by_slope = open.share[only] + open.slope[only] * std::max(softer, stiffer);
  const double by_gap = std::max(0.0, open.gap[only] - open.room[only]) / (1.0 + gamma / (1.0 + u));
  out.of[only] = by_slope + by_gap;
  out.along = only;
  for (int i = 0; i < gaps_.size(); ++i) {
    if (i != only && !gaps_.leaves_out(i) && open.room[i] < out.of[only]) out.along = -1;
  }
  return out.along >= 0;
}

/// How far x goes per error of the gap of contact i, if no more than one other contact pushes. That
/// one may let go, or push as much as its stiffness allows: the worst lies at one of these ends.
double ProxyBound::per_gap(const Open& open, int i, double gamma) const noexcept {
  const double alone = 1.0 / (1.0 + gamma);
  if (open.involved == 1) return alone;
  const int j = i == open.only ? open.other : open.only;
  const double t = 1.0 + gaps_.gamma()[j] / (1.0 + uncertainty_[j]);
  const double cosine = gaps_.gradients().col(i).dot(gaps_.contacts().into.col(j));
  const double square = cosine * cosine, stays = (1.0 + gamma) * t - square;
  const double both = std::sqrt(std::max(0.0, t * t - square * (2.0 * t - 1.0)));
  return std::max(alone, stays > kParallel ? both / stays : HUGE_VAL);
}

/// One or two contacts are concerned, and no other one is touched on a way of this length.
bool ProxyBound::few(const Open& open, double way) const noexcept {
  for (int i = 0; i < gaps_.size() && open.involved <= 2; ++i) {
    const bool one = i == open.only || (open.involved == 2 && i == open.other);
    if (!one && !gaps_.leaves_out(i) && open.room[i] < way + open.gap[i]) return false;
  }
  return open.involved <= 2;
}

/// Their sum, with e_0. Sets `along` if one contact alone is concerned: what it adds along its
/// normal is then in `of`, and the rest in `everywhere`.
double ProxyBound::of_each_contact(Open& open, const Remainder* left,
                                   ProxyError& out) const noexcept {
  double off = out.everywhere, part[kMaxPlanes];  // part: a way along the normal
  for (int i = 0; i < gaps_.size(); ++i) {
    const bool curved = gaps_.is_curved(i);
    part[i] = 0.0;
    if (!curved && open.slope[i] + open.share[i] + open.gap[i] == 0.0) continue;
    const double u = uncertainty_[i], gamma = gaps_.gamma()[i];
    const double as_force = u < 1.0 ? std::min(1.0, 0.5 * std::sqrt(gamma / (1.0 - u))) : 1.0;
    const double most = open.involved == 1 ? 1.0 : kWedge;
    const double as_gap = gamma > 0.0 ? std::min(most, 0.5 * std::sqrt((1.0 + u) / gamma)) : most;
    // Its true gradient may be shorter: the same gap is then a longer way.
    const double gradient = curved ? gaps_.scale()[i] * left[i].gradient : 0.0;
    const double longer = 1.0 / std::max(1.0 - gradient, 1.0 - kMostBent);
    part[i] = longer * std::max(0.0, open.gap[i] - open.room[i]);
    out.of[i] = open.share[i] + open.slope[i] * as_force + part[i] * as_gap;
    off += out.of[i];
  }
  open.few = open.bent < kMostPressed && few(open, 2.0 * off / (1.0 - open.bent));
  if (!open.few) return off;
  off = out.everywhere;
  for (int left_over = open.involved, i = open.only; left_over > 0; --left_over, i = open.other) {
    const double u = uncertainty_[i], gamma = gaps_.gamma()[i], softest = gamma / (1.0 - u);
    const double as_force = u < 1.0 ? softest * per_gap(open, i, softest) : 1.0;
    part[i] = open.slope[i] * as_force + part[i] * per_gap(open, i, gamma / (1.0 + u));
    out.of[i] = open.share[i] + part[i];
    off += out.of[i];
  }
  if (open.involved == 1) {
    out.along = open.only;
    out.of[out.along] = part[out.along];
    out.everywhere = off - part[out.along];
  }
  return off;
}

/// On a way E forces turn and gaps bend: E <= off + bent E + c E^2. What c is on the whole way is
/// known for one that is assumed, the more the longer; it holds if E is no longer. At twice what
/// it is without c there is no root beyond. False: none holds, or the way is too long for what a
/// sample tells of a body.
bool ProxyBound::grow(const Open& open, double off, const Remainder* left,
                      ProxyError& out) const noexcept {
  const double stays = std::max(1.0 - open.bent, 1.0 - kMostPressed);
  for (const double times : {1.25, 2.0}) {
    const double most = times * off / stays;
    double c = 0.0;
    bool follows = true;
    for (int i = 0; i < gaps_.size(); ++i) {
      if (!gaps_.is_curved(i)) continue;
      const double scale = gaps_.scale()[i];
      const double bend = scale * left[i].bend_within(most);
      follows = follows && left[i].grows * most <= 1.0;
      c += 0.5 * scale * solver_.l()[i] * left[i].third_within(most);
      // On its way x may also touch what it does not touch here.
      if (open.gap[i] + most + 0.5 * bend * most * most <= open.room[i]) continue;
      follows = follows && bend * most <= kMostFar;
      c += 0.5 * bend * (open.involved == 1 && solver_.l()[i] > 0.0 ? 1.0 : kWedge);
    }
    const double root = stays * stays - 4.0 * c * off;
    if (!follows || root < 0.0) return false;
    const double grown = 2.0 / (stays + std::sqrt(root));
    if (grown * off > most) continue;
    if (gaps_.curved() == 0) return true;
    if (out.along < 0) {
      out.of *= kMargin * grown;
      out.everywhere *= kMargin * grown;
      return true;
    }
    // Forces that turn and gaps that bend lead anywhere, and so does the turn of the normal to x^.
    const double along = out.of[out.along], scale = gaps_.scale()[out.along];
    const double turned = left[out.along].gradient + left[out.along].bend_within(most) * most;
    out.everywhere = kMargin * (grown * off - along + scale * turned * along);
    out.of[out.along] = kMargin * along;
    return true;
  }
  return false;
}

}  // namespace haptic::core
