#include "tests/report/linear_algebra/problem.hpp"

#include <Eigen/QR>
#include <cmath>
#include <random>

namespace haptic::report {
namespace {

using Eigen::MatrixXd;

MatrixXd random_matrix(std::mt19937_64& random, int rows, int cols) {
  std::normal_distribution<double> normal;
  MatrixXd A(rows, cols);
  for (Eigen::Index i = 0; i < A.size(); ++i) A.data()[i] = normal(random);
  return A;
}

MatrixXd orthonormal(std::mt19937_64& random, int rows, int cols) {
  return Eigen::HouseholderQR<MatrixXd>(random_matrix(random, rows, cols)).householderQ() *
         MatrixXd::Identity(rows, cols);
}

}  // namespace

std::vector<Problem> problems(int m, int n, double cond, int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Problem> result;
  for (int i = 0; i < count; ++i) {
    Eigen::VectorXd s(n);
    for (int k = 0; k < n; ++k) s[k] = std::pow(cond, -static_cast<double>(k) / (n - 1));
    const MatrixXd A =
        orthonormal(random, m, n) * s.asDiagonal() * orthonormal(random, n, n).transpose();
    const Eigen::VectorXd x = random_matrix(random, n, 1);
    const Eigen::VectorXd b = A * x;
    result.push_back({{A.data(), A.data() + A.size()},
                      {b.data(), b.data() + b.size()},
                      {x.data(), x.data() + x.size()}});
  }
  return result;
}

}  // namespace haptic::report
