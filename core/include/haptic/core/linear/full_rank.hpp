#pragma once
/// Least squares by QR if the rank is beyond doubt; if not, it says so and solves nothing
/// (core/METHOD.md#solver-choice).

#include "haptic/core/linear/householder.hpp"

namespace haptic::core {

/// Below this ratio of singular values (equilibrated columns) the rank is in doubt.
inline constexpr double kRankThreshold = 1e-8;
/// Below this ratio the diagonal of R is not trusted, and the smallest singular value is estimated.
inline constexpr double kDiagonalThreshold = 1e-4;

struct FullRank {
  bool solved{false};     ///< y is the answer; else it is scrap
  double condition{0.0};  ///< of the equilibrated A; infinite if it is singular or m < n
};

/// A: m x n, column-major, overwritten by R. b: m, overwritten by Q^T b. Scratch: n each. y: n. Any
/// m, n >= 1. `kernel` is the one for m x n.
[[nodiscard]] FullRank solve_full_rank(const HouseholderKernel& kernel, int m, int n, double* A,
                                       double* b, double* column_norm2, double* inverse_diagonal,
                                       double* y) noexcept;
[[nodiscard]] FullRank solve_full_rank(int m, int n, double* A, double* b, double* column_norm2,
                                       double* inverse_diagonal, double* y) noexcept;

}  // namespace haptic::core
