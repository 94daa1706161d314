#pragma once
/// Householder triangularisation of a small matrix together with its right-hand side, in place
/// (METHOD 4.2). Column-major storage; sizes fixed at compile time where M, N > 0 so that the loops
/// unroll, taken from the arguments where they are 0. No pivoting: the caller orders the columns.

#include <cmath>

namespace haptic::core {

/// A (m x n, leading dimension m) becomes R in its upper triangle; b (m) becomes Q^T b. m >= n.
/// `column_norm` (n) gets the norms of A's columns, so that R_kk / column_norm[k] is the diagonal
/// of the R of the equilibrated matrix: column scaling changes R by that factor and Q not at all.
template <int M, int N>
inline void householder(double* A, double* b, double* column_norm, int m_run = M,
                        int n_run = N) noexcept {
  const int m = M > 0 ? M : m_run;
  const int n = N > 0 ? N : n_run;
  for (int k = 0; k < n; ++k) {
    double sum = 0.0;
    for (int i = 0; i < m; ++i) sum += A[k * m + i] * A[k * m + i];
    column_norm[k] = std::sqrt(sum);
  }
  for (int k = 0; k < n; ++k) {
    if (k == m - 1) break;  // nothing below the diagonal
    double* column = A + k * m;
    double below = 0.0;
    for (int i = k + 1; i < m; ++i) below += column[i] * column[i];
    if (below == 0.0) continue;
    const double head = column[k];
    const double norm = k == 0 ? column_norm[0] : std::sqrt(head * head + below);
    const double alpha = head > 0.0 ? -norm : norm;
    const double v0 = head - alpha;  // no cancellation: opposite signs
    // H = I - beta v v^T with v = (v0, column below), beta = 2 / v^T v = 1 / (norm (norm +
    // |head|)).
    const double beta = -1.0 / (alpha * v0);
    for (int j = k + 1; j < n; ++j) {
      double* other = A + j * m;
      double s = v0 * other[k];
      for (int i = k + 1; i < m; ++i) s += column[i] * other[i];
      s *= beta;
      other[k] -= s * v0;
      for (int i = k + 1; i < m; ++i) other[i] -= s * column[i];
    }
    double s = v0 * b[k];
    for (int i = k + 1; i < m; ++i) s += column[i] * b[i];
    s *= beta;
    b[k] -= s * v0;
    for (int i = k + 1; i < m; ++i) b[i] -= s * column[i];
    column[k] = alpha;
  }
}

}  // namespace haptic::core
