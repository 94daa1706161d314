// Without eps parallel or opposite planes make G singular. With it every set of planes has one
// answer: planes that can all be met are met after a few proximal steps, each of which divides what
// eps left by 1e4 or more; planes that contradict each other keep a violation, and the first step
// is then the x of least violation. A larger eps would call an acute wedge infeasible, a smaller
// one would be rounding.
#include "haptic/core/projection/contact_dual.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

/// If a violation above this share of the deepest one remains, the planes contradict each other.
constexpr double kInfeasible = 1e-4;
constexpr int kRefinements = 3;  // each divides a violation by 1e4 or more

}  // namespace

void ContactDual::begin(int count, std::uint32_t left_out) noexcept {
  count_ = count;
  left_out_ = left_out;
  hold_none();
}

void ContactDual::hold_none() noexcept {
  l_.setZero();
  active_ = 0;
  n_held_ = factored_ = 0;
}

void ContactDual::solve(const Vector& r) noexcept {
  int left = kMostSolves;
  solve(r, left);
}

/// Proximal steps on the dual, each with the multipliers of the one before: they converge to eps =
/// 0 if all contacts can be met; if not, the first step is the answer.
bool ContactDual::meet(const Vector& r, double deepest) noexcept {
  Vector shifted = r;
  int left = kMostSolves;
  for (int n = 0; n <= kRefinements; ++n) {
    solve(shifted, left);
    double violation = 0.0;
    for (int i = 0; i < count_; ++i) {
      violation = std::max(violation, r[i] + kEpsilon * l_[i] - pushed(i));
    }
    if (n == 0 && violation > kInfeasible * deepest) return false;
    if (violation <= 1e-15 * deepest) break;
    for (int i = 0; i < count_; ++i) shifted[i] = r[i] + kEpsilon * l_[i];
  }
  return true;
}

double ContactDual::pushed(int i) const noexcept {
  double sum = 0.0;
  for (int k = 0; k < n_held_; ++k) sum += G_(i, held_[k]) * l_[held_[k]];
  return sum;
}

void ContactDual::solve(const Vector& r, int& left) noexcept {
  double largest = 0.0;
  for (int i = 0; i < count_; ++i) largest = std::max(largest, r[i]);
  settle(r, largest, left);
  std::uint32_t refused = 0;
  while (left > 0) {
    int wanted = -1;
    double steepest = 1e-14 * largest;
    for (int i = 0; i < count_; ++i) {
      if (has(active_ | refused | left_out_, i)) continue;
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
    // A contact that entered and left at once would do so for ever: rounding decided that it is
    // met.
    refused = active_ == before ? refused | 1u << wanted : 0;
  }
}

void ContactDual::settle(const Vector& r, double largest, int& left) noexcept {
  Vector s;
  while (n_held_ > 0 && left > 0) {
    --left;
    solve_held(r, s);
    double step = 1.0;
    for (int k = 0; k < n_held_; ++k) {
      const double l = l_[held_[k]];
      if (s[k] <= 0.0) step = std::min(step, l / (l - s[k]));
    }
    if (!(step >= 0.0)) step = 0.0;  // 0 / 0: a contact that was to enter with nothing
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

/// Rows of L_ before the first contact that left stay: a contact that enters costs one row.
void ContactDual::solve_held(const Vector& r, Vector& s) noexcept {
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
