// Two orthogonal factorisations: a column-pivoted Householder QR of A finds the rank r, then the r
// rows of R are orthonormalised, R = L Q^T, and y = Q L^{-1} Q_A^T b is the solution of least norm.
// The rows are orthogonalised twice, because once is not enough if two of them are nearly parallel.
#include "haptic/core/linear/minimum_norm.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

double dot(const double* a, const double* b, int n) noexcept {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// v <- v minus its parts along the `count` orthonormal vectors of `basis` (stride n), twice: once
/// is not enough when v nearly lies in their span.
void orthogonalise(const double* basis, int count, int n, double* v, double* along) noexcept {
  for (int pass = 0; pass < 2; ++pass) {
    for (int j = 0; j < count; ++j) {
      const double part = dot(basis + j * n, v, n);
      if (along != nullptr) along[j] += part;
      for (int i = 0; i < n; ++i) v[i] -= part * basis[j * n + i];
    }
  }
}

}  // namespace

int minimum_norm(double* A, double* b, int m, int n, double threshold, double* y) noexcept {
  int column_of[kMaxQ];
  for (int j = 0; j < n; ++j) column_of[j] = j;
  std::fill(y, y + n, 0.0);

  int rank = 0;
  double first = 0.0;
  for (int k = 0; k < std::min(m, n); ++k) {
    int pivot = k;
    double largest = -1.0;
    for (int j = k; j < n; ++j) {
      const double norm2 = dot(A + j * m + k, A + j * m + k, m - k);
      if (norm2 > largest) {
        largest = norm2;
        pivot = j;
      }
    }
    const double norm = std::sqrt(largest);
    if (k == 0) first = norm;
    if (!(norm > threshold * first) || norm == 0.0) break;
    ++rank;
    if (pivot != k) {
      std::swap(column_of[pivot], column_of[k]);
      std::swap_ranges(A + k * m, A + (k + 1) * m, A + pivot * m);
    }
    double* column = A + k * m;
    const double alpha = column[k] > 0.0 ? -norm : norm;
    const double v0 = column[k] - alpha;
    const double beta = -1.0 / (alpha * v0);
    const auto reflect = [&](double* other) {
      const double s = beta * (v0 * other[k] + dot(column + k + 1, other + k + 1, m - k - 1));
      other[k] -= s * v0;
      for (int i = k + 1; i < m; ++i) other[i] -= s * column[i];
    };
    for (int j = k + 1; j < n; ++j) reflect(A + j * m);
    reflect(b);
    column[k] = alpha;
  }

  // R y' = b over the first `rank` rows: with R = L Q^T (rows orthonormalised), y' = Q L^{-1} b.
  double rows[kMaxQ * kMaxQ];
  for (int k = 0; k < rank; ++k) {
    double* row = rows + k * n;
    for (int j = 0; j < n; ++j) row[j] = j < k ? 0.0 : A[j * m + k];
    double along[kMaxQ]{};
    orthogonalise(rows, k, n, row, along);
    const double length = std::sqrt(dot(row, row, n));
    double z = b[k];
    for (int j = 0; j < k; ++j) z -= along[j] * b[j];
    b[k] = z / length;  // b becomes z = L^{-1} b, row by row
    for (int j = 0; j < n; ++j) row[j] /= length;
  }
  for (int k = 0; k < rank; ++k) {
    for (int j = 0; j < n; ++j) y[column_of[j]] += rows[k * n + j] * b[k];
  }
  return rank;
}

void remove_span(double* B, int m, int k, double threshold, double* f) noexcept {
  int kept = 0;
  for (int j = 0; j < k; ++j) {
    double* v = B + kept * m;
    if (j != kept) std::copy(B + j * m, B + (j + 1) * m, v);
    const double before = std::sqrt(dot(v, v, m));
    orthogonalise(B, kept, m, v, nullptr);
    const double after = std::sqrt(dot(v, v, m));
    if (!(after > threshold * before)) continue;
    for (int i = 0; i < m; ++i) v[i] /= after;
    ++kept;
  }
  orthogonalise(B, kept, m, f, nullptr);
}

VecQ rank_metric_root(const MatXQ& J, const DofLayout& layout, const VecA& Z_q) noexcept {
  VecQ weight = VecQ::Ones(layout.n_q());
  double z_x = 0.0;
  int counted = 0;
  for (int i = 0; i < layout.n_a(); ++i) {
    const double column = J.col(layout.actuated(i)).squaredNorm();
    if (column > 0.0 && Z_q[i] > 0.0) {
      z_x += Z_q[i] / column;
      ++counted;
    }
  }
  z_x = counted > 0 ? z_x / counted : 1.0;
  for (int i = 0; i < layout.n_a(); ++i) {
    if (Z_q[i] > 0.0) weight[layout.actuated(i)] = 1.0 / std::sqrt(Z_q[i]);
  }
  for (int i = 0; i < layout.n_n(); ++i) {
    const double column = J.col(layout.sensed(i)).squaredNorm();
    if (column > 0.0) weight[layout.sensed(i)] = 1.0 / std::sqrt(z_x * column);
  }
  return weight;
}

}  // namespace haptic::core
