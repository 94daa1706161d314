#include "haptic/core/linear/full_rank.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic::core {

FullRank solve_full_rank(const HouseholderKernel& kernel, int m, int n, double* A, double* b,
                         double* column_norm2, double* inverse_diagonal, double* y) noexcept {
  FullRank answer{false, std::numeric_limits<double>::infinity()};
  if (m < n) return answer;
  kernel.factor(m, n, A, b, column_norm2, inverse_diagonal);
  DiagonalRange range = diagonal_range(m, n, A, column_norm2);
  if (!(range.smallest2 > 0.0)) return answer;
  if (range.smallest2 < kDiagonalThreshold * kDiagonalThreshold * range.largest2) {
    range.smallest2 =
        std::min(range.smallest2, smallest_singular2(m, n, A, column_norm2, inverse_diagonal, y));
  }
  // Judged in squares: nothing that follows waits for the root.
  answer.condition = std::sqrt(range.largest2 / range.smallest2);
  if (!(range.largest2 * (kRankThreshold * kRankThreshold) <= range.smallest2)) return answer;
  kernel.back_substitute(m, n, A, b, inverse_diagonal, y);
  double finite = 0.0;  // 0 times what is not finite is not 0
  for (int k = 0; k < n; ++k) finite += 0.0 * y[k];
  answer.solved = finite == 0.0;
  return answer;
}

FullRank solve_full_rank(int m, int n, double* A, double* b, double* column_norm2,
                         double* inverse_diagonal, double* y) noexcept {
  if (m < n) return {false, std::numeric_limits<double>::infinity()};
  return solve_full_rank(householder_kernel(m, n), m, n, A, b, column_norm2, inverse_diagonal, y);
}

}  // namespace haptic::core
