#include "haptic/core/linear/least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic/core/linear/minimum_norm.hpp"

namespace haptic::core {

namespace {

constexpr double square(double value) noexcept {
  return value * value;
}

}  // namespace

LeastSquares::LeastSquares(int n_x, const DofLayout& layout)
    : layout_(layout),
      n_x_(n_x),
      n_q_(layout.n_q()),
      kernel_(householder_kernel(n_x, layout.n_q())),
      dq_(VecQ::Zero(layout.n_q())),
      null_in_doubt_(VecA::Zero(layout.n_a())),
      standard_in_doubt_(VecA::Zero(layout.n_a())) {
  int k = 0;
  for (int i = 0; i < layout_.n_n(); ++i) order_[k++] = layout_.sensed(i);
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
  diagonal_ = {};
  if (n_x_ >= n_q_) {
    load(J, dx);
    kernel_.factor(n_x_, n_q_, A_, b_, column_norm2_, inverse_diagonal_);
    diagonal_ = diagonal_range(n_x_, n_q_, A_, column_norm2_);
    if (diagonal_.smallest2 > 0.0 &&
        diagonal_.smallest2 < square(kDiagonalThreshold) * diagonal_.largest2) {
      diagonal_.smallest2 =
          std::min(diagonal_.smallest2,
                   smallest_singular2(n_x_, n_q_, A_, column_norm2_, inverse_diagonal_, y_));
    }
    if (diagonal_.smallest2 > 0.0 &&
        diagonal_.smallest2 >= square(kRankThreshold) * diagonal_.largest2) {
      kernel_.back_substitute(n_x_, n_q_, A_, b_, inverse_diagonal_, y_);
      double finite = 0.0;  // 0 times what is not finite is not 0
      for (int k = 0; k < n_q_; ++k) {
        dq_[order_[k]] = y_[k];
        finite += 0.0 * y_[k];
      }
      residual2_ = 0.0;
      for (int i = n_q_; i < n_x_; ++i) residual2_ += b_[i] * b_[i];
      status_ = ProjectionStatus::kExact;
      if (finite == 0.0) return;
    }
  }
  solve_in_doubt(J, dx, Z_q);
}

double LeastSquares::condition() const noexcept {
  return diagonal_.smallest2 > 0.0 ? std::sqrt(diagonal_.largest2 / diagonal_.smallest2)
                                   : std::numeric_limits<double>::infinity();
}

double LeastSquares::residual() const noexcept {
  return std::sqrt(residual2_);
}

VecA LeastSquares::force_from_row(int first) const noexcept {
  const int n_n = layout_.n_n();
  VecA force(layout_.n_a());
  for (int i = n_n; i < n_q_; ++i) {
    double sum = 0.0;
    for (int k = first; k <= i; ++k) sum += A_[i * n_x_ + k] * b_[k];
    force[i - n_n] = sum;
  }
  return force;
}

VecA LeastSquares::null_space_force() const noexcept {
  return status_ == ProjectionStatus::kExact ? force_from_row(layout_.n_n()) : null_in_doubt_;
}

VecA LeastSquares::standard_force() const noexcept {
  return status_ == ProjectionStatus::kExact ? force_from_row(0) : standard_in_doubt_;
}

void LeastSquares::solve_in_doubt(const MatXQ& J, const VecX& dx, const VecA& Z_q) noexcept {
  status_ = ProjectionStatus::kRankDeficient;
  dq_.setZero();
  null_in_doubt_.setZero();
  standard_in_doubt_.setZero();
  residual2_ = dx.allFinite() ? dx.squaredNorm() : 0.0;
  if (!J.allFinite() || !dx.allFinite()) return;

  const VecQ weight = doubt_weight(J, Z_q);
  for (int k = 0; k < n_q_; ++k) {
    for (int i = 0; i < n_x_; ++i) A_[k * n_x_ + i] = J(i, k) * weight[k];
  }
  std::copy_n(dx.data(), n_x_, b_);
  const int rank = core::minimum_norm(A_, b_, n_x_, n_q_, kRankThreshold, y_);
  const VecQ dq = weight.cwiseProduct(Eigen::Map<const VecQ>(y_, n_q_));
  if (!dq.allFinite()) return;
  dq_ = dq;
  if (rank == n_q_) status_ = ProjectionStatus::kIllConditioned;
  residual2_ = (dx - J.lazyProduct(dq_)).squaredNorm();
  forces_in_doubt(J, dx);
}

/// The square root of M^{-1}: its actuated block is Z_q, and sensed DoFs are weighted by what they do
/// in X per unit, so that no choice of units changes the answer.
VecQ LeastSquares::doubt_weight(const MatXQ& J, const VecA& Z_q) const noexcept {
  VecQ weight = VecQ::Ones(n_q_);
  double z_x = 0.0;
  int counted = 0;
  for (int i = 0; i < layout_.n_a(); ++i) {
    const double column = J.col(layout_.actuated(i)).squaredNorm();
    if (column > 0.0 && Z_q[i] > 0.0) {
      z_x += Z_q[i] / column;
      ++counted;
    }
  }
  z_x = counted > 0 ? z_x / counted : 1.0;
  for (int i = 0; i < layout_.n_a(); ++i) {
    if (Z_q[i] > 0.0) weight[layout_.actuated(i)] = 1.0 / std::sqrt(Z_q[i]);
  }
  for (int i = 0; i < layout_.n_n(); ++i) {
    const double column = J.col(layout_.sensed(i)).squaredNorm();
    if (column > 0.0) weight[layout_.sensed(i)] = 1.0 / std::sqrt(z_x * column);
  }
  return weight;
}

/// Eq. (3) by its definition: f* = dx less its part in the span of J_n, then J_a^T f*.
void LeastSquares::forces_in_doubt(const MatXQ& J, const VecX& dx) noexcept {
  VecX f_star = dx;
  for (int k = 0; k < layout_.n_n(); ++k) {
    std::copy_n(J.data() + layout_.sensed(k) * n_x_, n_x_, A_ + k * n_x_);
  }
  remove_span(A_, n_x_, layout_.n_n(), kRankThreshold, f_star.data());
  for (int i = 0; i < layout_.n_a(); ++i) {
    null_in_doubt_[i] = J.col(layout_.actuated(i)).dot(f_star);
    standard_in_doubt_[i] = J.col(layout_.actuated(i)).dot(dx);
  }
  if (!null_in_doubt_.allFinite()) null_in_doubt_.setZero();  // squares of J overflow before J does
  if (!standard_in_doubt_.allFinite()) standard_in_doubt_.setZero();
}

}  // namespace haptic::core
