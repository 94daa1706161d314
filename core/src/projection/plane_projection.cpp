// Eq. (27) by its dual, min 1/2 l^T (G + eps) l - l^T r over l >= 0: an unknown per plane, whatever
// n_x is. r holds the violations of the probe, G = A W^-1 A^T with unit normals, and
// x = x_probe - W^-1 A^T l.
//
// Without eps parallel or opposite planes make G singular. With it every set of planes has one
// answer: planes that can all be met are met after a few proximal steps, each of which divides what
// eps left by 1e4 or more; planes that contradict each other keep a violation, and the first step
// is then the x of least violation. A larger eps would call an acute wedge infeasible, a smaller
// one would be rounding.
#include "haptic/core/projection/plane_projection.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace haptic::core {

namespace {

/// eps, relative to the dual's unit diagonal: large against rounding, small against any wedge that
/// a simulation has.
constexpr double kEpsilon = 1e-10;
/// If a violation above this share of the deepest one remains, the planes contradict each other.
constexpr double kInfeasible = 1e-4;
constexpr int kRefinements = 3;  // each divides a violation by 1e4 or more

constexpr bool has(std::uint32_t set, int i) noexcept {
  return (set >> i & 1u) != 0;
}

}  // namespace

PlaneProjection::PlaneProjection(const ConfigurationSpace& space, TaskMetric metric)
    : space_(&space), metric_(std::move(metric)), at_(VecX::Zero(space.n_x())) {
  for (const Coordinate& c : space.coordinates()) {
    linear_.push_back(c.kind == CoordinateKind::kLinear);
  }
}

void PlaneProjection::set(const PlaneSet& planes, const VecX& x) noexcept {
  count_ = planes.size();
  skipped_ = 0;
  hold_none();
  at_ = x;
  A_ = planes.normals;
  PlaneSet::Normals& D = contacts_.into;
  D.resize(A_.rows(), count_);
  contacts_.depth.setConstant(count_, -1.0);
  for (int i = 0; i < count_; ++i) {
    D.col(i) = metric_.steepest(A_.col(i));
    const double norm = std::sqrt(A_.col(i).dot(D.col(i)));
    if (!(norm > 0.0) || !std::isfinite(norm)) {
      skipped_ |= 1u << i;
      A_.col(i).setZero();
      D.col(i).setZero();
      beta_[i] = 0.0;
      continue;
    }
    A_.col(i) /= norm;
    D.col(i) /= norm;
    beta_[i] = planes.offsets[i] / norm - A_.col(i).dot(at_);
  }
  for (int i = 0; i < count_; ++i) {
    for (int j = 0; j <= i; ++j) G_(i, j) = G_(j, i) = A_.col(i).dot(D.col(j));
    G_(i, i) += kEpsilon;
  }
}

PlaneStatus PlaneProjection::project(const VecX& x_probe, VecX& x) noexcept {
  x = x_probe;
  if (count_ == 0) return PlaneStatus::kFree;
  space_->difference(x_probe, at_, y_);
  Small r = Small::Zero();
  double deepest = 0.0;
  const PlaneSet::Normals& D = contacts_.into;
  for (int i = 0; i < count_; ++i) {
    r[i] = has(skipped_, i) ? -1.0 : A_.col(i).dot(y_) - beta_[i];
    deepest = std::max(deepest, r[i]);
    contacts_.depth[i] = r[i];
  }
  if (!(deepest > 0.0)) {
    hold_none();
    return PlaneStatus::kFree;
  }
  const PlaneStatus status = multipliers(r, deepest);
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    bool held = !linear_[static_cast<std::size_t>(k)];
    for (int i = 0; i < count_; ++i) held = held || (has(active_, i) && D(k, i) != 0.0);
    // What no plane holds is where the probe is, to the bit: nothing is in its way.
    if (!held) continue;
    // From at_ on, not from x_probe: an angle or a rotation there may be one turn or one sign away.
    x[k] = at_[k] + y_[k];
    for (int i = 0; i < count_; ++i) {
      if (has(active_, i)) x[k] -= l_[i] * D(k, i);
    }
  }
  return status;
}

/// Proximal steps on the dual, each with the multipliers of the one before: they converge to eps =
/// 0 if all planes can be met; if not, the first step is the answer.
PlaneStatus PlaneProjection::multipliers(const Small& r, double deepest) noexcept {
  Small shifted = r;
  int left = kMostSolves;
  for (int n = 0; n <= kRefinements; ++n) {
    solve(shifted, left);
    double violation = 0.0;
    for (int i = 0; i < count_; ++i) {
      violation = std::max(violation, r[i] + kEpsilon * l_[i] - pushed(i));
    }
    if (n == 0 && violation > kInfeasible * deepest) return PlaneStatus::kInfeasible;
    if (violation <= 1e-15 * deepest) break;
    for (int i = 0; i < count_; ++i) shifted[i] = r[i] + kEpsilon * l_[i];
  }
  return PlaneStatus::kActive;
}

double PlaneProjection::pushed(int i) const noexcept {
  double sum = 0.0;
  for (int k = 0; k < n_held_; ++k) sum += G_(i, held_[k]) * l_[held_[k]];
  return sum;
}

void PlaneProjection::hold_none() noexcept {
  l_.setZero();
  active_ = 0;
  n_held_ = factored_ = 0;
}

void PlaneProjection::solve(const Small& r, int& left) noexcept {
  double largest = 0.0;
  for (int i = 0; i < count_; ++i) largest = std::max(largest, r[i]);
  settle(r, largest, left);
  std::uint32_t refused = 0;
  while (left > 0) {
    int wanted = -1;
    double steepest = 1e-14 * largest;
    for (int i = 0; i < count_; ++i) {
      if (has(active_ | refused | skipped_, i)) continue;
      const double w = r[i] - pushed(i);
      if (w > steepest) {
        steepest = w;
        wanted = i;
      }
    }
    if (wanted < 0) return;
    const std::uint32_t before = active_;
    active_ |= 1u << wanted;
    held_[n_held_++] = wanted;
    settle(r, largest, left);
    // A plane that entered and left at once would do so for ever: rounding decided that it is met.
    refused = active_ == before ? refused | 1u << wanted : 0;
  }
}

void PlaneProjection::settle(const Small& r, double largest, int& left) noexcept {
  Small s;
  while (n_held_ > 0 && left > 0) {
    --left;
    solve_held(r, s);
    double step = 1.0;
    for (int k = 0; k < n_held_; ++k) {
      const double l = l_[held_[k]];
      if (s[k] <= 0.0) step = std::min(step, l / (l - s[k]));
    }
    if (!(step >= 0.0)) step = 0.0;  // 0 / 0: a plane that was to enter with nothing
    int kept = 0;
    for (int k = 0; k < n_held_; ++k) {
      const int i = held_[k];
      const double next = l_[i] + step * (s[k] - l_[i]);
      if (s[k] <= 0.0 && next <= 1e-15 * largest) {
        l_[i] = 0.0;
        active_ &= ~(1u << i);
        factored_ = std::min(factored_, kept);
      } else {
        l_[i] = next;
        held_[kept++] = i;
      }
    }
    n_held_ = kept;
    if (step >= 1.0) return;
  }
}

/// Rows of L_ before the first plane that left stay: a plane that enters costs one row.
void PlaneProjection::solve_held(const Small& r, Small& s) noexcept {
  for (int i = factored_; i < n_held_; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = G_(held_[i], held_[j]);
      for (int k = 0; k < j; ++k) sum -= L_(i, k) * L_(j, k);
      // eps keeps every pivot above 0
      L_(i, j) = i == j ? std::sqrt(std::max(sum, 0.5 * kEpsilon)) : sum / L_(j, j);
    }
  }
  factored_ = n_held_;
  for (int i = 0; i < n_held_; ++i) {
    double sum = r[held_[i]];
    for (int k = 0; k < i; ++k) sum -= L_(i, k) * s[k];
    s[i] = sum / L_(i, i);
  }
  for (int i = n_held_ - 1; i >= 0; --i) {
    double sum = s[i];
    for (int k = i + 1; k < n_held_; ++k) sum -= L_(k, i) * s[k];
    s[i] = sum / L_(i, i);
  }
}

}  // namespace haptic::core
