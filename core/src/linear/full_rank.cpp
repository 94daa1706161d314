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
  double condition2 = diagonal_condition2(n, column_norm2, inverse_diagonal);
  if (!(condition2 <= std::numeric_limits<double>::max())) return answer;
  if (condition2 > 1.0 / (kDiagonalThreshold * kDiagonalThreshold)) {
    condition2 = std::max(condition2, inverse_norm2(m, n, A, column_norm2, inverse_diagonal, y));
  }
  // Judged in squares: nothing that follows waits for the root.
  answer.condition = std::sqrt(condition2);
  if (!(condition2 <= 1.0 / (kRankThreshold * kRankThreshold))) return answer;
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
