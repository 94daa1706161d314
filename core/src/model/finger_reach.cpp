// The nearest pose of the finger to an x that it cannot reach, globally and without a seed.
//
// det J does not vanish inside the allowed set, so f is locally invertible there and a point with a
// residual can always be improved: the optimum lies on the edge. The edge is traced once, on a
// grid, when a scene loads. nearest() takes the best traced point of each constraint and slides it
// along that constraint's curve. What would break it: a set in which det J changes its sign,
// because a minimum could then lie inside (the branch is therefore a constraint too).
#include "finger_reach.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic/core/error.hpp"

namespace haptic::core {

namespace {

/// The lower limit of a coordinate is even, its upper one follows.
enum EdgeLimit : int {
  kLLower,
  kLUpper,
  kTLower,
  kTUpper,
  kC1Lower,
  kC1Upper,
  kC2Lower,
  kC2Upper,
  kBranch,
  kNoClosure
};

constexpr double kScaleL = 0.02;  // m per unit of scaled travel (core/METHOD.md#finger-linkage)
/// Joint limits of the valid region (core/METHOD.md#finger-linkage), rad; they bound the mean of
/// ||J_a|| only.
constexpr double kJointLower = -0.3, kMcpUpper = 1.75, kPipUpper = 2.0;

double squared_distance(const ReachPoint& p, double q1, double q2) noexcept {
  return (p.q1 - q1) * (p.q1 - q1) + (p.q2 - q2) * (p.q2 - q2);
}

}  // namespace

FingerReach::FingerReach(const FingerLinkage& linkage) : linkage_(linkage) {
  trace();
}

double FingerReach::value(int constraint, double l, double t, const LinkagePose& p) const noexcept {
  // The s of core/METHOD.md#inverse-map, of the order of a length.
  if (constraint == kBranch) return p.det() * p.c1 * p.c2;
  const FingerDimensions& d = linkage_.dimensions();
  const double at[] = {l, t, p.c1, p.c2};
  const double lower[] = {d.l_x_lower, d.q_B_lower, d.slider1_lower, d.slider2_lower};
  const double upper[] = {d.l_x_upper, d.q_B_upper, d.slider1_upper, d.slider2_upper};
  const int i = constraint / 2;
  return constraint % 2 == 0 ? at[i] - lower[i] : upper[i] - at[i];
}

int FingerReach::violated(double l, double t, int but) const noexcept {
  LinkagePose p;
  if (!linkage_.pose(l, t, p)) return kNoClosure;
  for (int c = 0; c < kConstraints; ++c) {
    if (c != but && !(value(c, l, t, p) >= -FingerLinkage::kLimitSlack)) return c;
  }
  return -1;
}

bool FingerReach::gradient(int constraint, double l, double t, const LinkagePose& p, double& g_l,
                           double& g_t) const noexcept {
  constexpr double kBox[][2] = {{1.0, 0.0}, {-1.0, 0.0}, {0.0, 1.0}, {0.0, -1.0}};
  if (constraint < kC1Lower) {
    g_l = kBox[constraint][0];
    g_t = kBox[constraint][1];
    return true;
  }
  if (constraint < kBranch) {
    const double* slope = constraint < kC2Lower ? p.c1_k : p.c2_k;
    const double sign = constraint % 2 == 0 ? 1.0 : -1.0;
    g_l = sign * slope[0];
    g_t = sign * slope[1];
    return true;
  }
  double H[2][2][2];
  if (!linkage_.hessian(l, t, H)) return false;
  double g[2];
  for (int k = 0; k < 2; ++k) {
    const double det_k = H[0][0][k] * p.J(1, 1) + p.J(0, 0) * H[1][1][k] - H[0][1][k] * p.J(1, 0) -
                         p.J(0, 1) * H[1][0][k];
    g[k] = det_k * p.c1 * p.c2 + p.det() * (p.c1_k[k] * p.c2 + p.c1 * p.c2_k[k]);
  }
  g_l = g[0];
  g_t = g[1];
  return true;
}

bool FingerReach::constraints(double l, double t, Constraints& out) const noexcept {
  static_assert(kConstraints - kC1Lower == std::tuple_size_v<Constraints>);
  LinkagePose p;
  if (!linkage_.pose(l, t, p)) return false;
  for (int c = kC1Lower; c < kConstraints; ++c) {
    Constraint& constraint = out[static_cast<std::size_t>(c - kC1Lower)];
    constraint.room = value(c, l, t, p);
    // The branch's slope needs second derivatives: not where it is far off.
    const bool far =
        c == kBranch && constraint.room > 0.25 * linkage_.dimensions().proximal_phalanx;
    double(&g)[2] = constraint.gradient;
    g[0] = g[1] = 0.0;
    if (!far && !gradient(c, l, t, p, g[0], g[1])) return false;
  }
  return true;
}

void FingerReach::add(double l, double t, int constraint) {
  LinkagePose p;
  if (linkage_.pose(l, t, p)) edge_.push_back({l, t, p.q1, p.q2, constraint});
}

/// The last feasible point on the way from a feasible to an infeasible one.
void FingerReach::add_crossing(double l_in, double t_in, double l_out, double t_out) {
  double inside = 0.0, outside = 1.0;
  int constraint = kBranch;
  for (int i = 0; i < 50; ++i) {
    const double s = 0.5 * (inside + outside);
    const int v = violated(l_in + s * (l_out - l_in), t_in + s * (t_out - t_in));
    if (v < 0) {
      inside = s;
    } else {
      outside = s;
      constraint = v;
    }
  }
  // Where the linkage stops closing a slider is at its own limit first; nothing to trace there.
  if (constraint == kNoClosure) return;
  add(l_in + inside * (l_out - l_in), t_in + inside * (t_out - t_in), constraint);
}

void FingerReach::trace() {
  const FingerDimensions& d = linkage_.dimensions();
  const double step_l = (d.l_x_upper - d.l_x_lower) / kGrid;
  const double step_t = (d.q_B_upper - d.q_B_lower) / kGrid;
  const auto l_at = [&](int i) { return i == kGrid ? d.l_x_upper : d.l_x_lower + i * step_l; };
  const auto t_at = [&](int j) { return j == kGrid ? d.q_B_upper : d.q_B_lower + j * step_t; };

  std::vector<char> feasible((kGrid + 1) * (kGrid + 1));
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i <= kGrid; ++i) {
    for (int j = 0; j <= kGrid; ++j) {
      const bool in = violated(l_at(i), t_at(j)) < 0;
      feasible[static_cast<std::size_t>(i * (kGrid + 1) + j)] = in;
      LinkagePose p;
      if (!in || !linkage_.pose(l_at(i), t_at(j), p)) continue;
      if (p.q1 > kJointLower && p.q1 < kMcpUpper && p.q2 > kJointLower && p.q2 < kPipUpper) {
        sum += std::hypot(p.J(0, 0), p.J(1, 0));
        ++count;
      }
    }
  }
  const auto in = [&](int i, int j) {
    return feasible[static_cast<std::size_t>(i * (kGrid + 1) + j)] != 0;
  };
  for (int i = 0; i <= kGrid; ++i) {
    for (int j = 0; j <= kGrid; ++j) {
      if (!in(i, j)) continue;
      if (i == 0) add(l_at(i), t_at(j), kLLower);
      if (i == kGrid) add(l_at(i), t_at(j), kLUpper);
      if (j == 0) add(l_at(i), t_at(j), kTLower);
      if (j == kGrid) add(l_at(i), t_at(j), kTUpper);
      if (i > 0 && !in(i - 1, j)) add_crossing(l_at(i), t_at(j), l_at(i - 1), t_at(j));
      if (i < kGrid && !in(i + 1, j)) add_crossing(l_at(i), t_at(j), l_at(i + 1), t_at(j));
      if (j > 0 && !in(i, j - 1)) add_crossing(l_at(i), t_at(j), l_at(i), t_at(j - 1));
      if (j < kGrid && !in(i, j + 1)) add_crossing(l_at(i), t_at(j), l_at(i), t_at(j + 1));
    }
  }
  if (edge_.empty() || count == 0) {
    throw SceneError(
        "finger_exoskeleton: with these dimensions the linkage closes nowhere inside its limits");
  }
  mean_J_a_ = sum / count;
}

/// Newton steps along the gradient, back onto the curve of the constraint.
bool FingerReach::restore(int constraint, double& l, double& t) const noexcept {
  for (int i = 0; i < 8; ++i) {
    LinkagePose p;
    double g_l = 0.0, g_t = 0.0;
    if (!linkage_.pose(l, t, p) || !gradient(constraint, l, t, p, g_l, g_t)) return false;
    const double v = value(constraint, l, t, p);
    if (std::abs(v) < 1e-14) return true;
    const double a = g_l * kScaleL;  // gradient in scaled coordinates
    const double norm2 = a * a + g_t * g_t;
    if (!(norm2 > 0.0)) return false;
    l -= v / norm2 * a * kScaleL;
    t -= v / norm2 * g_t;
  }
  LinkagePose p;
  return linkage_.pose(l, t, p) && std::abs(value(constraint, l, t, p)) < 1e-10;
}

ReachPoint FingerReach::slide(ReachPoint from, double q1, double q2) const noexcept {
  constexpr int kSteps = 20;
  constexpr double kShortest =
      1e-10;  // scaled travel: below it a step changes nothing that is felt
  ReachPoint best = from;
  for (int i = 0; i < kSteps; ++i) {
    LinkagePose p;
    double g_l = 0.0, g_t = 0.0;
    if (!linkage_.pose(best.l, best.t, p) ||
        !gradient(best.constraint, best.l, best.t, p, g_l, g_t)) {
      break;
    }
    // Tangent of the curve in scaled coordinates, and dx along it.
    const double tangent_l = -g_t * kScaleL, tangent_t = g_l * kScaleL;
    const double v1 = p.J(0, 0) * tangent_l + p.J(0, 1) * tangent_t;
    const double v2 = p.J(1, 0) * tangent_l + p.J(1, 1) * tangent_t;
    const double vv = v1 * v1 + v2 * v2;
    if (!(vv > 0.0)) break;
    double s = (v1 * (q1 - best.q1) + v2 * (q2 - best.q2)) / vv;
    // No further than a few cells of the trace at once: the curve is only locally straight.
    const double longest = 0.1 / std::hypot(tangent_l / kScaleL, tangent_t);
    s = std::clamp(s, -longest, longest);
    const double per_s = std::hypot(tangent_l / kScaleL, tangent_t);
    bool moved = false;
    for (; !moved && std::abs(s) * per_s > kShortest; s *= 0.5) {
      ReachPoint next = best;
      next.l = best.l + s * tangent_l;
      next.t = best.t + s * tangent_t;
      LinkagePose at;
      if (!restore(best.constraint, next.l, next.t) ||
          violated(next.l, next.t, best.constraint) >= 0 || !linkage_.pose(next.l, next.t, at)) {
        continue;
      }
      next.q1 = at.q1;
      next.q2 = at.q2;
      if (squared_distance(next, q1, q2) < squared_distance(best, q1, q2)) {
        best = next;
        moved = true;
      }
    }
    if (!moved) break;
  }
  return best;
}

ReachPoint FingerReach::nearest(double q1, double q2) const noexcept {
  if (!std::isfinite(q1)) q1 = 0.0;
  if (!std::isfinite(q2)) q2 = 0.0;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  double distance[kConstraints];
  const ReachPoint* seed[kConstraints]{};
  std::fill(std::begin(distance), std::end(distance), kFar);
  double closest = kFar;
  for (const ReachPoint& p : edge_) {
    const double d2 = squared_distance(p, q1, q2);
    if (d2 < distance[p.constraint]) {
      distance[p.constraint] = d2;
      seed[p.constraint] = &p;
      closest = std::min(closest, d2);
    }
  }
  // A traced point lies within a cell of the best of its curve: those far behind cannot win.
  const double worth_trying = std::sqrt(closest) + 0.05;
  ReachPoint best = edge_.front();
  double best_distance = kFar;
  for (int c = 0; c < kConstraints; ++c) {
    if (seed[c] == nullptr || std::sqrt(distance[c]) > worth_trying) continue;
    const ReachPoint p = slide(*seed[c], q1, q2);
    const double d2 = squared_distance(p, q1, q2);
    if (d2 < best_distance) {
      best_distance = d2;
      best = p;
    }
  }
  return best;
}

}  // namespace haptic::core
