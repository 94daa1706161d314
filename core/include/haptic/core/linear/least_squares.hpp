#pragma once
/// min ||J dq - dx|| for the small Jacobians of devices, by Householder QR of [J_n | J_a]: one
/// factorisation gives the linearised subspace proxy and the null-space force alike (METHOD 4.2).
/// Full column rank is solved directly; where min|R_kk|/max|R_kk| of the equilibrated J falls below
/// 1e-8, or n_x < n_q, the answer is the one of minimum norm in a metric whose actuated block is
/// Z_q (METHOD 4.3): bounded, unit-free, and said so by the status.

#include "haptic/core/model/dof_layout.hpp"
#include "haptic/core/projection/projection.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

class LeastSquares {
 public:
  /// Below this ratio of the diagonal of R (equilibrated) the rank is in doubt.
  static constexpr double kRankThreshold = 1e-8;

  LeastSquares(int n_x, const DofLayout& layout);

  /// J: n_x by n_q, columns in the order of q. dx: n_x. Z_q: n_a, the metric's actuated block.
  /// Never allocates. J or dx that is not finite gives dq = 0 and kRankDeficient.
  void solve(const MatXQ& J, const VecX& dx, const VecA& Z_q) noexcept;

  /// dq: n_q, in the order of q.
  [[nodiscard]] const VecQ& dq() const noexcept { return dq_; }
  /// S dq.
  [[nodiscard]] VecA dq_a() const noexcept { return layout_.select(dq_); }
  /// J_a^T (I - J_n J_n^+) dx = R22^T b_2: Eq. (4) for Z_x = I. n_a. Of the last solve().
  [[nodiscard]] const VecA& null_space_force() const noexcept { return null_space_force_; }
  /// max|R_kk|/min|R_kk| of the equilibrated J; infinite where it is singular.
  [[nodiscard]] double condition() const noexcept { return condition_; }
  /// kExact, kIllConditioned or kRankDeficient.
  [[nodiscard]] ProjectionStatus status() const noexcept { return status_; }
  /// ||dx - J dq||.
  [[nodiscard]] double residual() const noexcept { return residual_; }

 private:
  void load(const MatXQ& J, const VecX& dx) noexcept;
  template <int M, int N>
  void run() noexcept;
  void solve_in_doubt(const MatXQ& J, const VecX& dx, const VecA& Z_q) noexcept;

  DofLayout layout_;
  int n_x_;
  int n_q_;
  int order_[kMaxQ]{};  ///< column k of [J_n | J_a] is column order_[k] of J
  void (LeastSquares::*kernel_)() noexcept;
  double A_[kMaxX * kMaxQ];
  double b_[kMaxX];
  double column_norm_[kMaxQ];
  VecQ dq_{};
  VecA null_space_force_{};
  double condition_{0.0};
  double residual_{0.0};
  ProjectionStatus status_{ProjectionStatus::kNone};
};

}  // namespace haptic::core
