// Without eps parallel or opposite planes make G singular. With it every set of planes has one
// answer, and a number of proximal steps that nothing but rounding ends early makes x continuous
// and bounded in whatever is told: if G has the eigenvalue s, its part of x is met but for
// (eps / (s + eps))^kProximal. Planes that can all be met are; an acute wedge is beyond some
// hundred times its violation; of planes that contradict each other the violation is the least. A
// larger eps would give way to more wedges, a smaller one would lead x further away.
#include "haptic/core/contacts/contact_dual.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace haptic::core {

namespace {

/// If a violation above this share of the deepest one remains, the planes contradict each other.
constexpr double kInfeasible = 1e-4;
/// A violation below that share is rounding.
constexpr double kMet = 1e-15;
/// Every pivot is larger, but for rounding.
constexpr double kLeastPivot = 5e-11;
/// Cost of the smallest system, in multiplications.
constexpr int kLeast = 30;

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

void ContactDual::begin_at(const Vector& l) noexcept {
  hold_none();
  for (int i = 0; i < count_; ++i) {
    if (!(l[i] > 0.0) || has(left_out_, i)) continue;
    l_[i] = l[i];
    active_ |= 1u << i;
    held_[n_held_++] = i;
  }
}

void ContactDual::give(const Gives* gives) noexcept {
  gives_.contacts = 0;
  if (gives != nullptr) gives_ = *gives;
  summed_ = 0;
  factored_ = 0;
}

/// Row i, made when it is read: few of many contacts are held.
ContactDual::Gram::ConstRowXpr ContactDual::row(int i) noexcept {
  if (!has(gives_.contacts, i)) return std::as_const(products_).row(i);
  if (!has(summed_, i)) {
    summed_ |= 1u << i;
    const Vector& root = gives_.root;
    sums_.row(i).head(count_) =
        products_.row(i).head(count_) +
        (root[i] * root.head(count_)).transpose().cwiseProduct(gives_.cosine->row(i).head(count_));
  }
  return std::as_const(sums_).row(i);
}

void ContactDual::set_diagonal(int i, double square, double give) noexcept {
  eps_[i] = std::max(0.0, kEpsilon - give);
  put_diagonal(i, square + give + eps_[i]);
}

/// Proximal steps on the dual, each with the multipliers of the one before: they converge to eps =
/// 0 if all contacts can be met, else to the least violation.
bool ContactDual::meet(const Vector& r, double deepest) noexcept {
  Vector shifted;
  shifted.head(count_) = r.head(count_);
  double violation = 0.0;
  for (int n = 0; n < kProximal; ++n) {
    solve(shifted);
    violation = 0.0;
    for (int i = 0; i < count_; ++i) {  // by what eps gave way
      const double next = r[i] + eps_[i] * l_[i];
      violation = std::max(violation, std::abs(next - shifted[i]));
      shifted[i] = next;
    }
    if (violation <= kMet * deepest) return true;
  }
  return violation <= kInfeasible * deepest;
}

void ContactDual::solve(const Vector& r) noexcept {
  double largest = 0.0;
  for (int i = 0; i < count_; ++i) largest = std::max(largest, r[i]);
  settle(r, largest);
  std::uint32_t refused = 0;
  const auto all = static_cast<std::uint32_t>((1ull << count_) - 1);
  while (left_ > 0 && (all & ~(active_ | refused | left_out_)) != 0) {
    left_ -= count_ * n_held_;
    Vector w;
    w.head(count_) = r.head(count_);
    for (int k = 0; k < n_held_; ++k) {
      w.head(count_) -= l_[held_[k]] * row(held_[k]).head(count_).transpose();
    }
    int wanted = -1;
    double steepest = 1e-14 * largest;
    for (int i = 0; i < count_; ++i) {
      if (has(active_ | refused | left_out_, i) || !(w[i] > steepest)) continue;
      steepest = w[i];
      wanted = i;
    }
    if (wanted < 0) return;
    const std::uint32_t before = active_;
    active_ |= 1u << wanted;
    held_[n_held_++] = wanted;
    settle(r, largest);
    // A contact that entered and left at once would do so for ever: rounding decided that it is
    // met.
    refused = active_ == before ? refused | 1u << wanted : 0;
  }
}

void ContactDual::settle(const Vector& r, double largest) noexcept {
  Vector s;
  while (n_held_ > 0 && left_ > 0) {
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

/// Rows of L before the first contact that left stay: a contact that enters costs one row. By
/// columns, whose entries do not wait for each other.
void ContactDual::solve_held(const Vector& r, Vector& s) noexcept {
  left_ -= kLeast + n_held_ * n_held_;
  for (int i = factored_; i < n_held_; ++i) {
    left_ -= i * i / 2;
    const auto G = row(held_[i]);
    Vector next;
    for (int j = 0; j < i; ++j) next[j] = G[held_[j]];
    double pivot = diagonal_[held_[i]];
    for (int j = 0; j < i; ++j) {
      const double l = next[j] *= inverse_[j];
      const int after = i - j - 1;
      next.segment(j + 1, after) -= l * columns_.col(j).segment(j + 1, after);
      pivot -= l * l;
      columns_(i, j) = l;
    }
    L_.row(i).head(i) = next.head(i).transpose();
    inverse_[i] = 1.0 / std::sqrt(std::max(pivot, kLeastPivot));
  }
  factored_ = n_held_;
  for (int i = 0; i < n_held_; ++i) s[i] = r[held_[i]];
  for (int i = 0; i < n_held_; ++i) {
    const int after = n_held_ - i - 1;
    s[i] *= inverse_[i];
    s.segment(i + 1, after) -= s[i] * columns_.col(i).segment(i + 1, after);
  }
  for (int i = n_held_ - 1; i >= 0; --i) {
    s[i] *= inverse_[i];
    s.head(i) -= s[i] * L_.row(i).head(i).transpose();
  }
}

}  // namespace haptic::core
