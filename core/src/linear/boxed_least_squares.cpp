// Active set (C. Stark and R. Parker's bounded-variable least squares). p starts at 0, which is
// feasible. Each pass solves the free coordinates with the others fixed, moves towards that answer
// up to the first limit, which then holds; once the answer itself is feasible, a limit that the
// residual pulls away from lets go. Every pass lowers the norm, so a pass limit costs accuracy
// only, never safety: the last p is feasible and the best one seen.
#include "haptic/core/linear/boxed_least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic/core/linear/householder.hpp"
#include "haptic/core/linear/minimum_norm.hpp"

namespace haptic::core {

void BoxedLeastSquares::begin(int m, int n) noexcept {
  m_ = m;
  n_ = n;
  rows_ = 0;
  std::fill_n(A_, m * n, 0.0);
}

void BoxedLeastSquares::add(const MatXQ& J, const VecX& r) noexcept {
  const int rows = static_cast<int>(J.rows());
  for (int k = 0; k < n_; ++k) std::copy_n(J.data() + k * rows, rows, A_ + k * m_ + rows_);
  std::copy_n(r.data(), rows, b_ + rows_);
  rows_ += rows;
}

void BoxedLeastSquares::add_diagonal(const VecQ& weight, const VecQ& target) noexcept {
  for (int k = 0; k < n_; ++k) {
    A_[k * m_ + rows_] = weight[k];
    b_[rows_] = weight[k] * target[k];
    ++rows_;
  }
}

void BoxedLeastSquares::turn(int k, const double (&first)[2], const double (&second)[2]) noexcept {
  double* a = A_ + k * m_;
  double* b = a + m_;
  for (int i = 0; i < m_; ++i) {
    const double along = first[0] * a[i] + first[1] * b[i];
    b[i] = second[0] * a[i] + second[1] * b[i];
    a[i] = along;
  }
}

void BoxedLeastSquares::solve(const VecQ& lower, const VecQ& upper,
                              const VecQ& metric_root) noexcept {
  p_.setZero(n_);
  free_.setZero(n_);
  std::fill_n(side_, n_, 0);
  condition_ = 0.0;
  status_ = ProjectionStatus::kExact;
  limited_ = false;
  update_residual();
  if (!std::isfinite(residual2_)) return;
  // Each pass ends with one coordinate more on its limit, or at the best of the free ones: 2n of
  // them are usual, the rest is for limits that let go and take hold again.
  for (int pass = 0; pass < 4 * n_; ++pass) {
    solve_free(metric_root);
    const bool arrived = advance(lower, upper);
    update_residual();
    if (!arrived) continue;
    const int wrong = wrong_limit();
    if (wrong < 0) break;
    side_[wrong] = 0;
  }
  limited_ = std::any_of(side_, side_ + n_, [](int side) { return side != 0; });
}

/// free_ = the best of the free coordinates with the others where they are.
void BoxedLeastSquares::solve_free(const VecQ& metric_root) noexcept {
  n_free_ = 0;
  for (int k = 0; k < n_; ++k) {
    if (side_[k] == 0) free_index_[n_free_++] = k;
  }
  free_ = p_;
  if (n_free_ == 0) return;
  // In terms of the change from p_: the right-hand side is then the residual.
  for (int j = 0; j < n_free_; ++j) std::copy_n(A_ + free_index_[j] * m_, m_, work_ + j * m_);
  std::copy_n(r_, m_, rhs_);
  const FullRank full = solve_full_rank(householder_kernel(m_, n_free_), m_, n_free_, work_, rhs_,
                                        column_norm2_, inverse_diagonal_, y_);
  condition_ = full.condition;
  status_ = ProjectionStatus::kExact;
  if (!full.solved) {
    double root[kMaxQ];
    for (int j = 0; j < n_free_; ++j) {
      const double* column = A_ + free_index_[j] * m_;
      root[j] = metric_root[free_index_[j]];
      for (int i = 0; i < m_; ++i) work_[j * m_ + i] = root[j] * column[i];
    }
    std::copy_n(r_, m_, rhs_);
    const int rank = minimum_norm(work_, rhs_, m_, n_free_, kRankThreshold, y_);
    status_ =
        rank == n_free_ ? ProjectionStatus::kIllConditioned : ProjectionStatus::kRankDeficient;
    for (int j = 0; j < n_free_; ++j) y_[j] *= root[j];
  }
  for (int j = 0; j < n_free_; ++j) {
    if (!std::isfinite(y_[j])) return;  // p stays: nothing better is known
  }
  for (int j = 0; j < n_free_; ++j) free_[free_index_[j]] += y_[j];
}

bool BoxedLeastSquares::advance(const VecQ& lower, const VecQ& upper) noexcept {
  double share = 1.0;
  int first = -1;
  for (int j = 0; j < n_free_; ++j) {
    const int k = free_index_[j];
    const double way = free_[k] - p_[k];
    const double room = way > 0.0 ? upper[k] - p_[k] : lower[k] - p_[k];
    if (std::abs(way) > std::abs(room) && room / way < share) {
      share = room / way;
      first = k;
    }
  }
  if (first < 0) {
    p_ = free_;
    return true;
  }
  side_[first] = free_[first] > p_[first] ? 1 : -1;
  for (int j = 0; j < n_free_; ++j) {
    const int k = free_index_[j];
    p_[k] = std::clamp(p_[k] + share * (free_[k] - p_[k]), lower[k], upper[k]);
  }
  p_[first] = side_[first] > 0 ? upper[first] : lower[first];
  return false;
}

int BoxedLeastSquares::wrong_limit() const noexcept {
  int wrong = -1;
  double worst = 0.0;
  for (int k = 0; k < n_; ++k) {
    if (side_[k] == 0) continue;
    double pull = 0.0, norm2 = 0.0;  // pull > 0: the norm falls with a larger p_k
    for (int i = 0; i < m_; ++i) {
      pull += A_[k * m_ + i] * r_[i];
      norm2 += A_[k * m_ + i] * A_[k * m_ + i];
    }
    // Away from the limit by more than rounding, in the unit of the residual.
    const double away = norm2 > 0.0 ? -side_[k] * pull / std::sqrt(norm2) : 0.0;
    if (away > worst && away > 1e-14 * std::sqrt(residual2_)) {
      worst = away;
      wrong = k;
    }
  }
  return wrong;
}

void BoxedLeastSquares::update_residual() noexcept {
  std::copy_n(b_, m_, r_);
  for (int k = 0; k < n_; ++k) {
    if (p_[k] == 0.0) continue;
    for (int i = 0; i < m_; ++i) r_[i] -= p_[k] * A_[k * m_ + i];
  }
  residual2_ = 0.0;
  for (int i = 0; i < m_; ++i) residual2_ += r_[i] * r_[i];
}

VecQ BoxedLeastSquares::column_norms() const noexcept {
  VecQ norms(n_);
  for (int k = 0; k < n_; ++k) {
    double sum = 0.0;
    for (int i = 0; i < m_; ++i) sum += A_[k * m_ + i] * A_[k * m_ + i];
    norms[k] = std::sqrt(sum);
  }
  return norms;
}

}  // namespace haptic::core
