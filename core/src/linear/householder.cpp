#include "haptic/core/linear/householder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "householder_steps.hpp"

namespace haptic::core {

namespace {

template <int M, int N>
constexpr HouseholderKernel kernel() noexcept {
  return {&householder_steps::factor<M, N>, &householder_steps::back_substitute<M, N>};
}

}  // namespace

HouseholderKernel householder_kernel(int m, int n) noexcept {
  if (m == 2 && n == 2) return kernel<2, 2>();
  if (m == 6 && n == 2) return kernel<6, 2>();
  if (m == 6 && n == 6) return kernel<6, 6>();
  if (m == 27 && n == 10) return kernel<27, 10>();
  return kernel<0, 0>();
}

double diagonal_condition2(int n, const double* column_norm2,
                           const double* inverse_diagonal) noexcept {
  double worst2 = 1.0;
  for (int k = 0; k < n; ++k) {
    const double scaled2 = column_norm2[k] * inverse_diagonal[k] * inverse_diagonal[k];
    // At least 1 but for rounding. Also false for NaN, which a zero column makes.
    if (!(scaled2 > 0.5 && scaled2 <= std::numeric_limits<double>::max())) {
      return std::numeric_limits<double>::infinity();
    }
    worst2 = std::max(worst2, scaled2);
  }
  return worst2;
}

double inverse_norm2(int m, int n, const double* R, const double* column_norm2,
                     const double* inverse_diagonal, double* column) noexcept {
  double sum = 0.0;
  for (int k = 0; k < n; ++k) {  // column k of R^{-1}; row i of (R C)^{-1} is scaled by ||A_i||
    column[k] = inverse_diagonal[k];
    sum += column[k] * column[k] * column_norm2[k];
    for (int i = k - 1; i >= 0; --i) {
      double below = 0.0;
      for (int j = i + 1; j <= k; ++j) below += R[j * m + i] * column[j];
      column[i] = -below * inverse_diagonal[i];
      sum += column[i] * column[i] * column_norm2[i];
    }
  }
  return sum;
}

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

}  // namespace haptic::core
