#pragma once
/// Random matrices for tests and the report: Gaussian, orthonormal, and with singular values as
/// wanted.

#include <Eigen/Core>
#include <cmath>
#include <random>

#include "tests/support/dense_oracle.hpp"

namespace haptic::core::samples {

inline Eigen::MatrixXd gaussian(std::mt19937_64& random, int rows, int columns) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd A(rows, columns);
  for (int i = 0; i < A.size(); ++i) A.data()[i] = normal(random);
  return A;
}

/// Random orthonormal columns; rows >= columns.
inline Eigen::MatrixXd orthonormal(std::mt19937_64& random, int rows, int columns) {
  return oracle::orthonormal_basis(gaussian(random, rows, columns));
}

/// m x n (m >= n) with singular values from 1 down to 1/condition, evenly on a log scale.
inline Eigen::MatrixXd with_condition(std::mt19937_64& random, int m, int n, double condition) {
  const Eigen::MatrixXd U = orthonormal(random, m, n), V = orthonormal(random, n, n);
  Eigen::VectorXd s(n);
  for (int i = 0; i < n; ++i) s[i] = std::pow(condition, n > 1 ? -double(i) / (n - 1) : 0.0);
  return oracle::product(U * s.asDiagonal(), V.transpose());
}

}  // namespace haptic::core::samples
