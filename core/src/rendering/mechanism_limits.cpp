// A slider's end is a curve in the plane of two DoFs (l_x, q_B). The iteration is linear in q, so
// the curve is replaced by its tangent: the two DoFs are turned into one across the limit and one
// along it ("turned" columns), and the limit becomes a plain bound of the first. After the step
// restore() puts the pair back onto the curve by Newton's method.
//
// All lengths are in widths of the box, so that m and rad compare. apart() is the quick test:
// look() remembers how far one may go from a pose before any limit can matter, and a warm step
// stays within that distance almost always. If it is wrong, a step can pass a limit unseen:
// reach_of() is therefore half of the linear estimate, and never more than 2 % of the box.
#include "haptic/core/rendering/mechanism_limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic::core {

namespace {

/// Share of the box's width: rounding at a limit is no violation.
constexpr double kSlack = 1e-12;
constexpr int kNewtonSteps = 12;

/// The limit's slope per width of the box; its length.
double scaled(const Constraint& limit, const double (&width)[2], double (&slope)[2]) noexcept {
  slope[0] = limit.gradient[0] * width[0];
  slope[1] = limit.gradient[1] * width[1];
  return std::hypot(slope[0], slope[1]);
}

/// The step s (in widths) to where all `count` <= 2 limits have no room left; false where they do
/// not meet. One limit: the shortest step.
bool onto(const Constraint* const (&limits)[2], int count, const double (&width)[2],
          double (&s)[2]) noexcept {
  double g[2][2];
  const double length = scaled(*limits[0], width, g[0]);
  if (!(length > 0.0)) return false;
  if (count == 1) {
    for (int k = 0; k < 2; ++k) s[k] = -limits[0]->room / length * (g[0][k] / length);
    return true;
  }
  const double other = scaled(*limits[1], width, g[1]);
  const double det = g[0][0] * g[1][1] - g[0][1] * g[1][0];
  if (!(std::abs(det) > 1e-6 * length * other)) return false;
  s[0] = (-limits[0]->room * g[1][1] + limits[1]->room * g[0][1]) / det;
  s[1] = (-limits[1]->room * g[0][0] + limits[0]->room * g[1][0]) / det;
  return true;
}

}  // namespace

MechanismLimits::MechanismLimits(const Kinematics& kinematics) {
  for (const Mechanism& mechanism : kinematics.mechanisms()) {
    Pair& pair = pairs_[count_++];
    pair.mechanism = mechanism.kinematics;
    const int first = pair.first = mechanism.first_q;
    for (int k = 0; k < 2; ++k) {
      const DofSpec& dof = kinematics.dofs()[static_cast<std::size_t>(first + k)];
      pair.lower[k] = dof.lower;
      pair.upper[k] = dof.upper;
      pair.width[k] = dof.upper - dof.lower;
    }
  }
}

bool MechanismLimits::limits_at(const Pair& pair, double a, double b, All& all) const noexcept {
  VecQ q(2);
  q << a, b;
  Constraints own;
  if (pair.mechanism->constraints(q, own) != MapStatus::kOk) return false;
  std::copy(own.begin(), own.end(), all.begin());
  Constraint* box = all.data() + kOwn;
  box[0] = {a - pair.lower[0], {1.0, 0.0}};
  box[1] = {pair.upper[0] - a, {-1.0, 0.0}};
  box[2] = {b - pair.lower[1], {0.0, 1.0}};
  box[3] = {pair.upper[1] - b, {0.0, -1.0}};
  return true;
}

bool MechanismLimits::engaged() const noexcept {
  const std::span<const Pair> all = pairs();
  return std::any_of(all.begin(), all.end(), [](const Pair& pair) { return pair.engaged >= 0; });
}

bool MechanismLimits::apart(const VecQ& q, const VecQ& p) const noexcept {
  for (const Pair& pair : pairs()) {
    const int i = pair.first;
    double from[2], to[2];
    for (int k = 0; k < 2; ++k) {
      from[k] = (q[i + k] - pair.seen[k]) / pair.width[k];
      to[k] = from[k] + p[i + k] / pair.width[k];
    }
    if (!(std::max(std::hypot(from[0], from[1]), std::hypot(to[0], to[1])) <= pair.reach)) {
      return false;
    }
  }
  return true;
}

void MechanismLimits::look(const VecQ& q) noexcept {
  for (Pair& pair : pairs()) {
    pair.engaged = -1;
    pair.changed = false;
    pair.reach = -1.0;
    pair.seen[0] = q[pair.first];
    pair.seen[1] = q[pair.first + 1];
    if (limits_at(pair, pair.seen[0], pair.seen[1], pair.limits)) {
      pair.reach = reach_of(pair);
    } else {
      pair.limits = {};
    }
  }
}

/// Half of the distance to the nearest limit, by its own slope (at least a quarter of the steepest
/// one's, because a slope may be small just here), and no further than slopes stay what they are.
double MechanismLimits::reach_of(const Pair& pair) noexcept {
  constexpr double kFarthest = 0.02, kShare = 0.5, kSlope = 0.25;
  double steepest = 0.0, reach = kFarthest, g[2];
  for (int c = 0; c < kOwn; ++c) {
    steepest = std::max(steepest, scaled(pair.limits[static_cast<std::size_t>(c)], pair.width, g));
  }
  for (int c = 0; c < kOwn; ++c) {
    const Constraint& limit = pair.limits[static_cast<std::size_t>(c)];
    const double steepness = std::max(scaled(limit, pair.width, g), kSlope * steepest);
    if (steepness > 0.0) reach = std::min(reach, kShare * limit.room / steepness);
  }
  return reach;
}

void MechanismLimits::turn(BoxedLeastSquares& linear, VecQ& lower, VecQ& upper,
                           VecQ& metric_root) noexcept {
  for (Pair& pair : pairs()) {
    if (pair.engaged < 0) continue;
    const int i = pair.first;
    const double n0 = pair.across[0], n1 = pair.across[1];
    const double* w = pair.width;
    const Bounds bounds = pair.bounds = bounds_of(pair);
    pair.way[0] = n0 - bounds.slant * n1;
    pair.way[1] = n1 + bounds.slant * n0;
    linear.turn(i, {w[0] * pair.way[0], w[1] * pair.way[1]}, {-w[0] * n1, w[1] * n0});
    lower[i] = bounds.nearest;
    upper[i] = bounds.farthest;
    lower[i + 1] = bounds.back;
    upper[i + 1] = bounds.on;
    const double r0 = metric_root[i] / w[0], r1 = metric_root[i + 1] / w[1];
    metric_root[i] = std::hypot(n0 * r0, n1 * r1);
    metric_root[i + 1] = std::hypot(n1 * r0, n0 * r1);
  }
}

/// How far the pair's other limits let a step go along the engaged one, once that is reached. If
/// the straight way to it would break another limit, the way is slanted just past that one, so that
/// a corner is reached in one step.
MechanismLimits::Bounds MechanismLimits::bounds_of(const Pair& pair) noexcept {
  const double n0 = pair.across[0], n1 = pair.across[1];
  const auto engaged = static_cast<std::size_t>(pair.engaged);
  Bounds bounds;
  bounds.nearest = std::min(0.0, -pair.limits[engaged].room / pair.steepness);
  double room[kOwn + kBox], off[kOwn + kBox], along[kOwn + kBox];
  double least = 0.0;
  for (std::size_t c = 0; c < pair.limits.size(); ++c) {
    double g[2];
    scaled(pair.limits[c], pair.width, g);
    room[c] = std::max(0.0, pair.limits[c].room);
    off[c] = g[0] * n0 + g[1] * n1;
    along[c] = -g[0] * n1 + g[1] * n0;
    const double there = room[c] + off[c] * bounds.nearest;
    if (c == engaged || !(there < least) || std::abs(along[c]) < 1e-9 * std::abs(off[c])) continue;
    least = there;
    bounds.slant = -there / (along[c] * bounds.nearest);
  }
  for (std::size_t c = 0; c < pair.limits.size(); ++c) {
    if (c == engaged) continue;
    const double slanted = off[c] + bounds.slant * along[c];
    const double there = std::max(0.0, room[c] + slanted * bounds.nearest);
    if (slanted < 0.0) bounds.farthest = std::min(bounds.farthest, room[c] / -slanted);
    if (along[c] < 0.0 && there / -along[c] < bounds.on) {
      bounds.on = there / -along[c];
      bounds.ends_on = static_cast<int>(c);
    }
    if (along[c] > 0.0 && there / -along[c] > bounds.back) {
      bounds.back = there / -along[c];
      bounds.ends_back = static_cast<int>(c);
    }
  }
  return bounds;
}

void MechanismLimits::turn_back(VecQ& p) noexcept {
  for (Pair& pair : pairs()) {
    if (pair.engaged < 0) continue;
    const double across = p[pair.first], along = p[pair.first + 1];
    const Bounds& bounds = pair.bounds;
    const bool leaves = across > bounds.nearest;
    pair.blocked_by = -1;
    if (leaves && along >= bounds.on) pair.blocked_by = bounds.ends_on;
    if (leaves && along <= bounds.back) pair.blocked_by = bounds.ends_back;
    p[pair.first] = pair.width[0] * (pair.way[0] * across - pair.across[1] * along);
    p[pair.first + 1] = pair.width[1] * (pair.way[1] * across + pair.across[0] * along);
  }
}

bool MechanismLimits::engage(const VecQ& p) noexcept {
  bool any = false;
  for (Pair& pair : pairs()) {
    if (pair.engaged >= 0) {
      if (pair.blocked_by < 0 || pair.changed) continue;
      // The step leaves its limit and is held by another: that one is the limit to follow.
      lead(pair, pair.blocked_by);
      pair.changed = any = true;
      continue;
    }
    double deepest = kSlack;
    int worst = -1;
    for (int c = 0; c < kOwn; ++c) {  // the box needs none of this
      const Constraint& limit = pair.limits[static_cast<std::size_t>(c)];
      double g[2];
      const double steepness = scaled(limit, pair.width, g);
      const double left =
          limit.room + limit.gradient[0] * p[pair.first] + limit.gradient[1] * p[pair.first + 1];
      if (!(steepness > 0.0) || !(-left / steepness > deepest)) continue;
      deepest = -left / steepness;
      worst = c;
    }
    if (worst < 0) continue;
    lead(pair, worst);
    any = true;
  }
  return any;
}

void MechanismLimits::lead(Pair& pair, int limit) noexcept {
  double g[2];
  pair.engaged = limit;
  pair.steepness = scaled(pair.limits[static_cast<std::size_t>(limit)], pair.width, g);
  for (int k = 0; k < 2; ++k) pair.across[k] = g[k] / pair.steepness;
}

bool MechanismLimits::restore(const Pair& pair, double& a, double& b) const noexcept {
  int held[2]{}, count = 0;
  for (int n = 0; n < kNewtonSteps; ++n) {
    All all;
    if (!limits_at(pair, a, b, all)) return false;
    int worst = -1;
    double deepest = kSlack;
    for (std::size_t c = 0; c < all.size(); ++c) {
      double g[2];
      const double steepness = scaled(all[c], pair.width, g);
      if (steepness > 0.0 && -all[c].room / steepness > deepest) {
        deepest = -all[c].room / steepness;
        worst = static_cast<int>(c);
      }
    }
    if (worst < 0) return true;
    const bool known = (count > 0 && held[0] == worst) || (count > 1 && held[1] == worst);
    if (!known) {
      held[count < 2 ? count : 1] = worst;
      count = std::min(count + 1, 2);
    }
    const Constraint* const on[2] = {&all[static_cast<std::size_t>(held[0])],
                                     &all[static_cast<std::size_t>(held[1])]};
    double s[2];
    if (!onto(on, count, pair.width, s)) return false;
    a += s[0] * pair.width[0];
    b += s[1] * pair.width[1];
  }
  return false;
}

bool MechanismLimits::restore(VecQ& q) const noexcept {
  for (const Pair& pair : pairs()) {
    double a = q[pair.first], b = q[pair.first + 1];
    if (!restore(pair, a, b)) return false;
    q[pair.first] = std::clamp(a, pair.lower[0], pair.upper[0]);
    q[pair.first + 1] = std::clamp(b, pair.lower[1], pair.upper[1]);
  }
  return true;
}

}  // namespace haptic::core
