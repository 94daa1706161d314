#pragma once
/// The solvers of one size: normal equations and Eigen's QRs. M, N > 0: sizes known to the
/// compiler; 0: bounded by 27 x 10 and known at run time, as core/METHOD.md#solver-choice advises
/// above some 40 elements.

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "tests/report/linear_algebra/problem.hpp"

namespace haptic::report {

template <int M, int N>
struct Sized {
  static constexpr int kRows = M > 0 ? M : Eigen::Dynamic, kCols = N > 0 ? N : Eigen::Dynamic;
  static constexpr int kMaxRows = M > 0 ? M : 27, kMaxCols = N > 0 ? N : 10;
  using Matrix = Eigen::Matrix<double, kRows, kCols, 0, kMaxRows, kMaxCols>;
  using Square = Eigen::Matrix<double, kCols, kCols, 0, kMaxCols, kMaxCols>;
  using Row = Eigen::Matrix<double, kRows, 1, 0, kMaxRows, 1>;
  using Column = Eigen::Matrix<double, kCols, 1, 0, kMaxCols, 1>;

  static auto matrix(const double* A, int m, int n) { return Eigen::Map<const Matrix>(A, m, n); }
  static auto right(const double* b, int m) { return Eigen::Map<const Row>(b, m); }
  /// Where an answer is written.
  // NOLINTNEXTLINE(readability-non-const-parameter): Eigen writes through the map
  static auto answer(double* x, int n) { return Eigen::Map<Column>(x, n); }

  static void normal_equations(const double* A, const double* b, double* x, int m, int n) {
    const auto J = matrix(A, m, n);
    const Square JtJ = J.transpose() * J;
    const Column Jtb = J.transpose() * right(b, m);
    answer(x, n) = JtJ.llt().solve(Jtb);
  }
  template <typename Decomposition>
  static void eigen(const double* A, const double* b, double* x, int m, int n) {
    const Decomposition decomposition(matrix(A, m, n));
    answer(x, n) = decomposition.solve(right(b, m));
  }
};

template <int M, int N>
[[nodiscard]] std::vector<Solver> solvers_of_size() {
  using S = Sized<M, N>;
  using Matrix = typename S::Matrix;
  return {{"normal_equations", &S::normal_equations},
          {"eigen_householder_qr", &S::template eigen<Eigen::HouseholderQR<Matrix>>},
          {"eigen_col_piv_qr", &S::template eigen<Eigen::ColPivHouseholderQR<Matrix>>}};
}

}  // namespace haptic::report
