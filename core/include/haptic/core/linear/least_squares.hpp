#pragma once
/// min ||J dq - dx|| for the small Jacobians of devices, by Householder QR of [J_n | J_a]. One
/// factorisation gives the linearised subspace proxy, Eq. (8), and the null-space force, Eq. (4)
/// (core/METHOD.md#solver-choice). If the condition of the equilibrated J exceeds 1e8, or n_x <
/// n_q, a column-pivoted QR decides the rank. The answer is then the one of minimum norm in a
/// metric whose actuated block is Z_q (core/METHOD.md#rank-and-prior): bounded, independent of
/// units, and reported by status().

#include <memory>

#include "haptic/core/linear/householder.hpp"
#include "haptic/core/linear/stiffness_coupling.hpp"
#include "haptic/core/model/dof_layout.hpp"
#include "haptic/core/projection_status.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

class LeastSquares {
 public:
  /// `coupling`: of Z_q; null: it is diagonal. Used only if the rank is in doubt.
  LeastSquares(int n_x, const DofLayout& layout,
               std::shared_ptr<const StiffnessCoupling> coupling = nullptr);

  /// J: n_x by n_q, columns in the order of q. dx: n_x. Z_q: its diagonal, n_a; the full Z_q, with
  /// the coupling, is the metric's actuated block.
  /// Never allocates. J or dx that is not finite gives dq = 0 and kRankDeficient.
  void solve(const MatXQ& J, const VecX& dx, const VecA& Z_q) noexcept;

  // Results of the last solve():
  /// dq: n_q, in the order of q.
  [[nodiscard]] const VecQ& dq() const noexcept { return dq_; }
  /// S dq.
  [[nodiscard]] VecA dq_a() const noexcept { return layout_.select(dq_); }
  /// S J^+ d (n_a) for another d (n_x): by R alone, R^{-1} R^{-T} J^T d, for the J of the last
  /// solve(), whose status() must be kExact. Relative error about 1e-16 times condition()^2.
  [[nodiscard]] VecA also(const MatXQ& J, const VecX& d) const noexcept;
  /// (J_a^T (I - J_n J_n^+) J_a) v = R22^T R22 v, n_a, of the same J.
  [[nodiscard]] VecA actuated_square(const VecA& v) const noexcept;
  /// ||(S J^+)^T tau_a|| of the same J: what tau_a (n_a) is at the virtual coordinates.
  [[nodiscard]] double felt(const VecA& tau_a) const noexcept;
  /// J_a^T (I - J_n J_n^+) dx = R22^T b_2: Eq. (4) for Z_x = I. n_a.
  [[nodiscard]] VecA null_space_force() const noexcept;
  /// Condition of the equilibrated J: max|R_kk|/min|R_kk|; above 1e4 from the inverse of R;
  /// infinite if J is singular.
  [[nodiscard]] double condition() const noexcept { return condition_; }
  /// kExact, kIllConditioned or kRankDeficient.
  [[nodiscard]] ProjectionStatus status() const noexcept { return status_; }
  /// ||dx - J dq||.
  [[nodiscard]] double residual() const noexcept;

 private:
  void load(const MatXQ& J, const VecX& dx) noexcept;
  void solve_in_doubt(const MatXQ& J, const VecX& dx, const VecA& Z_q) noexcept;
  void force_in_doubt(const MatXQ& J, const VecX& dx) noexcept;

  DofLayout layout_;
  std::shared_ptr<const StiffnessCoupling> coupling_;
  int n_x_;
  int n_q_;
  int order_[kMaxQ]{};  ///< column k of [J_n | J_a] is column order_[k] of J
  HouseholderKernel kernel_;
  double A_[kMaxX * kMaxQ];
  double b_[kMaxX];
  double y_[kMaxQ];
  double column_norm2_[kMaxQ];
  double inverse_diagonal_[kMaxQ];
  VecQ dq_{};
  VecA null_in_doubt_{};  ///< null_space_force() if the QR does not give it
  double condition_{0.0};
  double residual2_{0.0};
  ProjectionStatus status_{ProjectionStatus::kNone};
};

}  // namespace haptic::core
