#pragma once
/// The steps of a Householder QR with sizes known at compile time where M, N > 0. Private to
/// householder.cpp. Two lanes by hand: a compiler may not reorder the sums of a dot product, so it
/// would not vectorise them; the loops over fixed sizes are unrolled by pragma, at -O2 as well.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "haptic/core/types.hpp"

namespace haptic::core::householder_steps {

using Pair = double __attribute__((vector_size(16)));

inline Pair load(const double* p) noexcept {
  Pair v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

inline void store(double* p, Pair v) noexcept {
  std::memcpy(p, &v, sizeof v);
}

/// a . b over `length`, in two chains of two lanes.
[[gnu::always_inline]] inline double dot(const double* a, const double* b, int length) noexcept {
  Pair even{0.0, 0.0}, odd{0.0, 0.0};
  int i = 0;
#pragma GCC unroll 16
  for (; i + 3 < length; i += 4) {
    even += load(a + i) * load(b + i);
    odd += load(a + i + 2) * load(b + i + 2);
  }
  if (i + 1 < length) {
    even += load(a + i) * load(b + i);
    i += 2;
  }
  even += odd;
  double sum = even[0] + even[1];
  if (i < length) sum += a[i] * b[i];
  return sum;
}

/// b -= s a over `length`.
[[gnu::always_inline]] inline void subtract(double s, const double* a, double* b,
                                            int length) noexcept {
  const Pair both{s, s};
  int i = 0;
#pragma GCC unroll 16
  for (; i + 1 < length; i += 2) store(b + i, load(b + i) - both * load(a + i));
  if (i < length) b[i] -= s * a[i];
}

/// Rows from `first` up to `end` of a column; outside them it is 0, but for what is R already.
struct Rows {
  int first, end;
};

inline Rows rows_of(const double* column, int m) noexcept {
  Rows rows{0, m};
  while (rows.first < m && column[rows.first] == 0.0) ++rows.first;
  while (rows.end > rows.first && column[rows.end - 1] == 0.0) --rows.end;
  return rows;
}

/// Step k: the reflection that clears column k below the diagonal, applied to what follows.
/// `rows`: of each column, or null: all. Columns that the reflection does not touch are skipped,
/// so a map whose outputs depend on few DoFs costs what it has entries.
[[gnu::always_inline]] inline void reflect(int m, int n, int k, double* A, double* b,
                                           double* inverse_diagonal, Rows* rows) noexcept {
  double* column = A + k * m;
  const double head = column[k];
  const int first = rows == nullptr ? k + 1 : std::max(rows[k].first, k + 1);
  const int end = rows == nullptr ? m : std::max(rows[k].end, first);
  const int length = end - first;
  const double below = dot(column + first, column + first, length);
  if (below == 0.0) {
    inverse_diagonal[k] = 1.0 / head;
    return;
  }
  // H = I - beta v v^T, v = (head - alpha, column below), beta = 2 / v^T v = -1 / (alpha v_0).
  const double norm = std::sqrt(head * head + below);
  const double alpha = head > 0.0 ? -norm : norm;
  const double v_0 = head - alpha;  // opposite signs: nothing cancels
  const double beta = -1.0 / (alpha * v_0);
  const auto apply = [&](double* other) {
    const double s = beta * (v_0 * other[k] + dot(column + first, other + first, length));
    other[k] -= s * v_0;
    subtract(s, column + first, other + first, length);
  };
#pragma GCC unroll 16
  for (int j = k + 1; j < n; ++j) {
    if (rows != nullptr) {
      Rows& touched = rows[j];
      const bool apart = touched.end <= first || end <= touched.first;
      if (apart && A[j * m + k] == 0.0) continue;
      touched = {std::min(touched.first, first), std::max(touched.end, end)};
    }
    apply(A + j * m);
  }
  apply(b);
  column[k] = alpha;
  inverse_diagonal[k] = -beta * v_0;  // 1 / alpha without another division
}

template <int M, int N>
void factor(int m_run, int n_run, double* A, double* b, double* column_norm2,
            double* inverse_diagonal) noexcept {
  const int m = M > 0 ? M : m_run;
  const int n = N > 0 ? N : n_run;
  if constexpr (N > 0) {
#pragma GCC unroll 16
    for (int k = 0; k < N; ++k) column_norm2[k] = dot(A + k * M, A + k * M, M);
    // A loop would keep k a variable, and with it every length.
    [&]<int... K>(std::integer_sequence<int, K...>) {
      (reflect(M, N, K, A, b, inverse_diagonal, nullptr), ...);
    }
    (std::make_integer_sequence<int, N>{});
  } else {
    Rows rows[kMaxQ];
    for (int k = 0; k < n; ++k) {
      rows[k] = rows_of(A + k * m, m);
      const double* const first = A + k * m + rows[k].first;
      column_norm2[k] = dot(first, first, rows[k].end - rows[k].first);
    }
    for (int k = 0; k < n; ++k) reflect(m, n, k, A, b, inverse_diagonal, rows);
  }
}

template <int M, int N>
void back_substitute(int m_run, int n_run, const double* R, const double* b,
                     const double* inverse_diagonal, double* y) noexcept {
  const int m = M > 0 ? M : m_run;
  const int n = N > 0 ? N : n_run;
#pragma GCC unroll 16
  for (int k = 0; k < n; ++k) y[k] = b[k];
#pragma GCC unroll 16
  for (int k = n - 1; k >= 0; --k) {
    y[k] *= inverse_diagonal[k];
#pragma GCC unroll 16
    for (int i = 0; i < k; ++i) y[i] -= y[k] * R[k * m + i];
  }
}

}  // namespace haptic::core::householder_steps
