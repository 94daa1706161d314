#pragma once
/// min ||A p - b|| over a box, by active set (the method of Stark and Parker;
/// core/METHOD.md#metric-and-limits). Used for the steps of the iteration behind Eq. (6): rows of A
/// are the Jacobian's, then those of a prior or of Levenberg-Marquardt damping.

#include "haptic/core/projection_status.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

class BoxedLeastSquares {
 public:
  /// A Jacobian, a prior and damping on top of one another.
  static constexpr int kMaxRows = kMaxX + 2 * kMaxQ;

  /// A new problem of m rows and n columns, rows to be added; m <= kMaxRows, n <= kMaxQ.
  void begin(int m, int n) noexcept;
  /// J p = r.
  void add(const MatXQ& J, const VecX& r) noexcept;
  /// weight_i p_i = weight_i target_i, n rows.
  void add_diagonal(const VecQ& weight, const VecQ& target) noexcept;

  /// Replaces the unknowns (p_k, p_k+1) by coefficients of the vectors `first` and `second`:
  /// (p_k, p_k+1) = p_k' first + p_k+1' second. Bounds, metric_root and p() then refer to
  /// the coefficients p'.
  void turn(int k, const double (&first)[2], const double (&second)[2]) noexcept;

  /// lower <= p <= upper, with lower <= 0 <= upper: 0 is the p to start from. `metric_root`: the
  /// square root of M^{-1}, n, that decides p if columns depend on each other. All rows must
  /// have been added. Never allocates; what is not finite gives p = 0.
  void solve(const VecQ& lower, const VecQ& upper, const VecQ& metric_root) noexcept;

  [[nodiscard]] const VecQ& p() const noexcept { return p_; }
  /// ||A p - b||^2.
  [[nodiscard]] double residual2() const noexcept { return residual2_; }
  /// True if a limit holds p against the pull of the residual.
  [[nodiscard]] bool limited() const noexcept { return limited_; }
  /// Condition of the free, equilibrated columns at the end; infinite if they depend on each other.
  [[nodiscard]] double condition() const noexcept { return condition_; }
  /// kExact, kIllConditioned or kRankDeficient, of the free columns at the end.
  [[nodiscard]] ProjectionStatus status() const noexcept { return status_; }
  /// ||A_k||, n: Marquardt's scale.
  [[nodiscard]] VecQ column_norms() const noexcept;

 private:
  void solve_free(const VecQ& metric_root) noexcept;
  /// Moves p_ towards free_ until the first limit; true if it got there.
  bool advance(const VecQ& lower, const VecQ& upper) noexcept;
  /// A limit that the residual pulls away from, or -1.
  [[nodiscard]] int wrong_limit() const noexcept;
  void update_residual() noexcept;

  int m_{0}, n_{0}, rows_{0};
  int n_free_{0};
  int free_index_[kMaxQ]{};
  int side_[kMaxQ]{};  ///< 0 free, +1 at the upper limit, -1 at the lower
  VecQ p_{}, free_{};
  double residual2_{0.0};
  double condition_{0.0};
  bool limited_{false};
  ProjectionStatus status_{ProjectionStatus::kNone};
  double column_norm2_[kMaxQ], inverse_diagonal_[kMaxQ], y_[kMaxQ];
  double A_[kMaxRows * kMaxQ], work_[kMaxRows * kMaxQ];
  double b_[kMaxRows], rhs_[kMaxRows], r_[kMaxRows];
};

}  // namespace haptic::core
