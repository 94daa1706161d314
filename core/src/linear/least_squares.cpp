// Columns are ordered [J_n | J_a], so one factorisation serves two methods, Eq. (19): with
// Q^T [J | dx] = [R11 R12 | b_1; 0 R22 | b_2], Eq. (8) is R^{-1} b and Eq. (4) is R22^T b_2.
// Another order would give Eq. (8) alone.
//
// If the rank is in doubt (condition above 1e8, or n_x < n_q) the answer of least M-norm is taken,
// Eq. (20): columns are scaled by M^{-1/2} before and dq after. M's actuated block must be Z_q, or
// the rendered stiffness has negative eigenvalues (core/METHOD.md#rank-and-prior).
#include "haptic/core/linear/least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "haptic/core/linear/minimum_norm.hpp"

namespace haptic::core {

LeastSquares::LeastSquares(int n_x, const DofLayout& layout,
                           std::shared_ptr<const StiffnessCoupling> coupling)
    : layout_(layout),
      coupling_(std::move(coupling)),
      n_x_(n_x),
      n_q_(layout.n_q()),
      kernel_(householder_kernel(n_x, layout.n_q())),
      dq_(VecQ::Zero(layout.n_q())),
      null_in_doubt_(VecA::Zero(layout.n_a())) {
  int k = 0;
  // A hand's fingers before its palm: their columns are then still short when their turn comes.
  for (int i = layout_.n_n() - 1; i >= 0; --i) order_[k++] = layout_.sensed(i);
  for (int i = 0; i < layout_.n_a(); ++i) order_[k++] = layout_.actuated(i);
}

void LeastSquares::load(const MatXQ& J, const VecX& dx) noexcept {
  const double* source = J.data();
  for (int k = 0; k < n_q_; ++k) {
    std::copy_n(source + order_[k] * n_x_, n_x_, A_ + k * n_x_);
  }
  std::copy_n(dx.data(), n_x_, b_);
}

void LeastSquares::solve(const MatXQ& J, const VecX& dx, const VecA& Z_q) noexcept {
  condition_ = std::numeric_limits<double>::infinity();
  if (n_x_ >= n_q_) {
    load(J, dx);
    const FullRank full =
        solve_full_rank(kernel_, n_x_, n_q_, A_, b_, column_norm2_, inverse_diagonal_, y_);
    condition_ = full.condition;
    if (full.solved) {
      for (int k = 0; k < n_q_; ++k) dq_[order_[k]] = y_[k];
      residual2_ = 0.0;
      for (int i = n_q_; i < n_x_; ++i) residual2_ += b_[i] * b_[i];
      status_ = ProjectionStatus::kExact;
      return;
    }
  }
  solve_in_doubt(J, dx, Z_q);
}

double LeastSquares::residual() const noexcept {
  return residual2_ > 0.0 ? std::sqrt(residual2_) : residual2_;  // of a square J it is 0
}

VecA LeastSquares::also(const MatXQ& J, const VecX& d) const noexcept {
  double y[kMaxQ];
  for (int k = 0; k < n_q_; ++k) {  // R^T y = J^T d
    double sum = J.col(order_[k]).dot(d);
    for (int i = 0; i < k; ++i) sum -= A_[k * n_x_ + i] * y[i];
    y[k] = sum * inverse_diagonal_[k];
  }
  const int n_n = layout_.n_n();
  VecA found(layout_.n_a());
  for (int k = n_q_ - 1; k >= n_n; --k) {  // R22 found = its part of y
    for (int j = k + 1; j < n_q_; ++j) y[k] -= A_[j * n_x_ + k] * y[j];
    found[k - n_n] = y[k] *= inverse_diagonal_[k];
  }
  return found;
}

VecA LeastSquares::actuated_square(const VecA& v) const noexcept {
  const int n_n = layout_.n_n(), n_a = layout_.n_a();
  const auto R = [&](int i, int j) { return A_[(n_n + j) * n_x_ + n_n + i]; };
  VecA Rv = VecA::Zero(n_a), square = VecA::Zero(n_a);
  for (int i = 0; i < n_a; ++i) {
    for (int j = i; j < n_a; ++j) Rv[i] += R(i, j) * v[j];
  }
  for (int i = 0; i < n_a; ++i) {
    for (int j = 0; j <= i; ++j) square[i] += R(j, i) * Rv[j];
  }
  return square;
}

double LeastSquares::felt(const VecA& tau_a) const noexcept {
  const int n_n = layout_.n_n();
  double y[kMaxQ], sum2 = 0.0;
  for (int k = n_n; k < n_q_; ++k) {  // R22^T y = tau_a
    y[k] = tau_a[k - n_n];
    for (int i = n_n; i < k; ++i) y[k] -= A_[k * n_x_ + i] * y[i];
    y[k] *= inverse_diagonal_[k];
    sum2 += y[k] * y[k];
  }
  return std::sqrt(sum2);
}

VecA LeastSquares::null_space_force() const noexcept {
  if (status_ != ProjectionStatus::kExact) return null_in_doubt_;
  const int n_n = layout_.n_n();
  VecA force(layout_.n_a());
  for (int i = n_n; i < n_q_; ++i) {
    double sum = 0.0;
    for (int k = n_n; k <= i; ++k) sum += A_[i * n_x_ + k] * b_[k];
    force[i - n_n] = sum;
  }
  return force;
}

void LeastSquares::solve_in_doubt(const MatXQ& J, const VecX& dx, const VecA& Z_q) noexcept {
  status_ = ProjectionStatus::kRankDeficient;
  dq_.setZero();
  null_in_doubt_.setZero();
  residual2_ = dx.allFinite() ? dx.squaredNorm() : 0.0;
  if (!J.allFinite() || !dx.allFinite()) return;

  const VecQ weight = rank_metric_root(J, layout_, Z_q);
  for (int k = 0; k < n_q_; ++k) {
    for (int i = 0; i < n_x_; ++i) A_[k * n_x_ + i] = J(i, k) * weight[k];
  }
  if (coupling_) coupling_->relax_columns(A_, n_x_, layout_);
  std::copy_n(dx.data(), n_x_, b_);
  const int rank = core::minimum_norm(A_, b_, n_x_, n_q_, kRankThreshold, y_);
  VecQ dq = Eigen::Map<const VecQ>(y_, n_q_);
  if (coupling_) {
    VecA y_a = layout_.select(dq);
    coupling_->relax(y_a);
    for (int i = 0; i < layout_.n_a(); ++i) dq[layout_.actuated(i)] = y_a[i];
  }
  dq = weight.cwiseProduct(dq);
  if (!dq.allFinite()) return;
  dq_ = dq;
  if (rank == n_q_) status_ = ProjectionStatus::kIllConditioned;
  residual2_ = (dx - J.lazyProduct(dq_)).squaredNorm();
  force_in_doubt(J, dx);
}

/// Eq. (3) by its definition: f* = dx less its part in the span of J_n, then J_a^T f*.
void LeastSquares::force_in_doubt(const MatXQ& J, const VecX& dx) noexcept {
  VecX f_star = dx;
  for (int k = 0; k < layout_.n_n(); ++k) {
    std::copy_n(J.data() + layout_.sensed(k) * n_x_, n_x_, A_ + k * n_x_);
  }
  remove_span(A_, n_x_, layout_.n_n(), kRankThreshold, f_star.data());
  for (int i = 0; i < layout_.n_a(); ++i) {
    null_in_doubt_[i] = J.col(layout_.actuated(i)).dot(f_star);
  }
  if (!null_in_doubt_.allFinite()) null_in_doubt_.setZero();  // squares of J overflow before J does
}

}  // namespace haptic::core
