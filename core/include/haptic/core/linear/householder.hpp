#pragma once
/// Householder QR of a small matrix together with its right-hand side
/// (core/METHOD.md#solver-choice): the one factorisation behind every renderer. Sizes that devices
/// have are unrolled (2x2, 6x2, 6x6, 27x10), every other size up to the bounds runs the same steps
/// in loops, and leaves out what is 0: in a hand on a palm most of J. No pivoting: the caller
/// orders the columns.
///
/// Equilibration. Scaling the columns, A C = Q (R C), leaves Q and so Q^T b alone and scales R's
/// columns; the solution is C times that of the scaled system. So A is factored as it is, and the
/// diagonal of the equilibrated R is |R_kk| / ||A_k||, which has no units.

namespace haptic::core {

/// Matrices are column-major without gaps. m >= n >= 1, n <= kMaxQ.
struct HouseholderKernel {
  /// A (m x n) becomes R in its upper triangle (below it: scrap); b (m) becomes Q^T b. Writes the
  /// squared norms of A's columns and 1 / R_kk (infinite if R_kk = 0), n each.
  void (*factor)(int m, int n, double* A, double* b, double* column_norm2,
                 double* inverse_diagonal) noexcept;
  /// y (n) = R^{-1} b of what factor() left.
  void (*back_substitute)(int m, int n, const double* R, const double* b,
                          const double* inverse_diagonal, double* y) noexcept;
};

/// The fastest kernel for m x n.
[[nodiscard]] HouseholderKernel householder_kernel(int m, int n) noexcept;

/// Square of the condition of the equilibrated matrix as R's diagonal shows it: the largest
/// (||A_k|| / R_kk)^2, since the largest R_kk / ||A_k|| is that of the first column, 1. At least 1;
/// infinite if a column is zero, depends on the others, or is not finite.
[[nodiscard]] double diagonal_condition2(int n, const double* column_norm2,
                                         const double* inverse_diagonal) noexcept;

/// ||(R C)^{-1}||_F^2: one over the smallest singular value, squared, to a factor between 1 and n.
/// The diagonal alone may underestimate the condition ten thousandfold. This costs as much as the
/// factorisation, so call it only if the diagonal gives cause. `column` (n) is scratch.
[[nodiscard]] double inverse_norm2(int m, int n, const double* R, const double* column_norm2,
                                   const double* inverse_diagonal, double* column) noexcept;

/// Below this ratio of singular values (equilibrated columns) the rank is in doubt.
inline constexpr double kRankThreshold = 1e-8;
/// Below this ratio the diagonal of R is not trusted, and the smallest singular value is estimated.
inline constexpr double kDiagonalThreshold = 1e-4;

struct FullRank {
  bool solved{false};     ///< y is the answer; else it is scrap
  double condition{0.0};  ///< of the equilibrated A; infinite if it is singular or m < n
};

/// Least squares if the rank is beyond doubt; if not, says so and solves nothing. A: m x n,
/// column-major, overwritten by R. b: m, overwritten by Q^T b. Scratch: n each. y: n. Any
/// m >= 1 and 1 <= n <= kMaxQ. `kernel` is the one for m x n.
[[nodiscard]] FullRank solve_full_rank(const HouseholderKernel& kernel, int m, int n, double* A,
                                       double* b, double* column_norm2, double* inverse_diagonal,
                                       double* y) noexcept;

}  // namespace haptic::core
