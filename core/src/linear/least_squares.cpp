#include "haptic/core/linear/least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic/core/linear/householder.hpp"
#include "haptic/core/linear/minimum_norm.hpp"

namespace haptic::core {

LeastSquares::LeastSquares(int n_x, const DofLayout& layout)
    : layout_(layout), n_x_(n_x), n_q_(layout.n_q()) {
  int k = 0;
  for (int i = 0; i < layout_.n_n(); ++i) order_[k++] = layout_.sensed(i);
  for (int i = 0; i < layout_.n_a(); ++i) order_[k++] = layout_.actuated(i);
  dq_ = VecQ::Zero(n_q_);
  null_space_force_ = VecA::Zero(layout_.n_a());
  kernel_ = n_x_ == 2 && n_q_ == 2   ? &LeastSquares::run<2, 2>
            : n_x_ == 6 && n_q_ == 2 ? &LeastSquares::run<6, 2>
            : n_x_ == 6 && n_q_ == 6 ? &LeastSquares::run<6, 6>
                                     : &LeastSquares::run<0, 0>;
}

void LeastSquares::load(const MatXQ& J, const VecX& dx) noexcept {
  const double* source = J.data();
  for (int k = 0; k < n_q_; ++k) {
    const double* column = source + order_[k] * n_x_;
    for (int i = 0; i < n_x_; ++i) A_[k * n_x_ + i] = column[i];
  }
  for (int i = 0; i < n_x_; ++i) b_[i] = dx[i];
}

template <int M, int N>
void LeastSquares::run() noexcept {
  const int m = M > 0 ? M : n_x_;
  const int n = N > 0 ? N : n_q_;
  householder<M, N>(A_, b_, column_norm_, m, n);
  // Smallest and largest |R_kk| of the equilibrated matrix; a zero or NaN column gives NaN, which
  // no comparison below takes for full rank.
  double smallest = 1.0, largest = 1.0;
  for (int k = 0; k < n; ++k) {
    const double scaled = std::abs(A_[k * m + k]) / column_norm_[k];
    if (k == 0) {
      smallest = largest = scaled;
    } else {
      smallest = std::min(scaled, smallest);
      largest = std::max(largest, scaled);
    }
    if (!(scaled > 0.0)) {
      smallest = 0.0;
      break;
    }
  }
  if (!(smallest >= kRankThreshold * largest)) {
    condition_ = smallest > 0.0 ? largest / smallest : std::numeric_limits<double>::infinity();
    status_ = ProjectionStatus::kRankDeficient;  // solve_in_doubt() decides
    return;
  }
  condition_ = largest / smallest;
  status_ = ProjectionStatus::kExact;

  const int n_n = layout_.n_n();
  for (int i = n_n; i < n; ++i) {  // R22^T b_2
    double sum = 0.0;
    for (int k = n_n; k <= i; ++k) sum += A_[i * m + k] * b_[k];
    null_space_force_[i - n_n] = sum;
  }
  double residual = 0.0;
  for (int i = n; i < m; ++i) residual += b_[i] * b_[i];
  residual_ = m > n ? std::sqrt(residual) : 0.0;

  for (int k = n - 1; k >= 0; --k) {
    double sum = b_[k];
    for (int j = k + 1; j < n; ++j) sum -= A_[j * m + k] * b_[j];
    b_[k] = sum / A_[k * m + k];
    dq_[order_[k]] = b_[k];
  }
}

void LeastSquares::solve(const MatXQ& J, const VecX& dx, const VecA& Z_q) noexcept {
  if (n_x_ >= n_q_) {
    load(J, dx);
    (this->*kernel_)();
    if (status_ == ProjectionStatus::kExact) return;
  } else {
    condition_ = std::numeric_limits<double>::infinity();
  }
  solve_in_doubt(J, dx, Z_q);
}

void LeastSquares::solve_in_doubt(const MatXQ& J, const VecX& dx, const VecA& Z_q) noexcept {
  status_ = ProjectionStatus::kRankDeficient;
  dq_.setZero();
  null_space_force_.setZero();
  residual_ = dx.allFinite() ? dx.norm() : 0.0;
  if (!J.allFinite() || !dx.allFinite()) return;

  // M^{-1/2}: actuated Z_q itself, sensed DoFs weighted by what they do in X per unit, so that no
  // choice of units changes the answer.
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
  for (int k = 0; k < n_q_; ++k) {
    for (int i = 0; i < n_x_; ++i) A_[k * n_x_ + i] = J(i, k) * weight[k];
  }
  std::copy(dx.data(), dx.data() + n_x_, b_);
  VecQ y(n_q_);
  const int rank = core::minimum_norm(A_, b_, n_x_, n_q_, kRankThreshold, y.data());
  const VecQ dq = weight.cwiseProduct(y);
  if (!dq.allFinite()) return;
  dq_ = dq;
  if (rank == n_q_) status_ = ProjectionStatus::kIllConditioned;
  const VecX error = dx - J.lazyProduct(dq_);
  residual_ = error.norm();

  // Eq. (3) by its definition: f* = dx less its part in the span of J_n, then J_a^T f*.
  VecX f_star = dx;
  for (int k = 0; k < layout_.n_n(); ++k) {
    std::copy(J.data() + layout_.sensed(k) * n_x_, J.data() + (layout_.sensed(k) + 1) * n_x_,
              A_ + k * n_x_);
  }
  remove_span(A_, n_x_, layout_.n_n(), kRankThreshold, f_star.data());
  for (int i = 0; i < layout_.n_a(); ++i) {
    null_space_force_[i] = J.col(layout_.actuated(i)).dot(f_star);
  }
}

}  // namespace haptic::core
