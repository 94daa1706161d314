#include "haptic/core/linear/householder.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/core/linear/random_matrix.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

using samples::gaussian;
using samples::with_condition;

struct Solved {
  Eigen::MatrixXd R{};
  Eigen::VectorXd Qt_b{}, y{}, norm2{}, inverse{};
  double condition2{};  ///< as far as the diagonal tells
};

Solved solve(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const int m = static_cast<int>(A.rows()), n = static_cast<int>(A.cols());
  Solved s{A, b, Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  const HouseholderKernel kernel = householder_kernel(m, n);
  kernel.factor(m, n, s.R.data(), s.Qt_b.data(), s.norm2.data(), s.inverse.data());
  kernel.back_substitute(m, n, s.R.data(), s.Qt_b.data(), s.inverse.data(), s.y.data());
  s.condition2 = diagonal_condition2(n, s.norm2.data(), s.inverse.data());
  return s;
}

struct Size {
  int m, n;
};
constexpr Size kSizes[] = {{1, 1}, {2, 1}, {2, 2}, {3, 2},   {3, 3},  {6, 2},
                           {6, 6}, {7, 5}, {9, 4}, {27, 10}, {72, 24}};

void expect_solved(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const Eigen::VectorXd want = oracle::least_squares(A, b);
  const double condition = oracle::condition(A);
  ASSERT_LT((solve(A, b).y - want).norm(), 2e-15 * condition * condition * (want.norm() + b.norm()))
      << A;
}

TEST(Householder, SolvesLikeEigenAtEverySize) {
  std::mt19937_64 random(1);
  for (const Size& size : kSizes) {
    for (int trial = 0; trial < 300; ++trial) {
      const Eigen::MatrixXd A = gaussian(random, size.m, size.n);
      ASSERT_NO_FATAL_FAILURE(expect_solved(A, gaussian(random, size.m, 1)));
    }
  }
}

/// Columns that begin and end anywhere, some of them empty between: fingers of a hand.
TEST(Householder, LeavesOutWhatIsZero) {
  std::mt19937_64 random(8);
  for (int trial = 0; trial < 3000; ++trial) {
    const Size size{10 + trial % 30, 4 + trial % 7};
    Eigen::MatrixXd A = gaussian(random, size.m, size.n);
    const auto draw = [&](int below) {
      return std::uniform_int_distribution<int>(0, below - 1)(random);
    };
    for (int k = 0; k < size.n; ++k) {
      if (draw(4) == 0) continue;
      const int first = draw(size.m), end = first + draw(size.m - first) + 1;
      A.col(k).head(first).setZero();
      A.col(k).tail(size.m - end).setZero();
      if (draw(3) == 0) A(first + draw(end - first), k) = 0.0;
    }
    if (!(oracle::condition(A) < 1e6)) continue;
    ASSERT_NO_FATAL_FAILURE(expect_solved(A, gaussian(random, size.m, 1))) << "trial " << trial;
  }
}

/// tests/report/STUDY.md#condition-sweep: forward error below 10 eps cond from 1 to 1e16, and never
/// a NaN.
TEST(Householder, ErrorGrowsWithTheConditionOnly) {
  std::mt19937_64 random(10);
  constexpr double kEps = std::numeric_limits<double>::epsilon();
  for (int power = 0; power <= 16; ++power) {
    const double condition = std::pow(10.0, power);
    for (int trial = 0; trial < 40; ++trial) {
      const Eigen::MatrixXd A = with_condition(random, 6, 6, condition);
      const Eigen::VectorXd want = gaussian(random, 6, 1);
      const Eigen::VectorXd b = (A.cast<long double>() * want.cast<long double>()).cast<double>();
      const Solved s = solve(A, b);
      ASSERT_TRUE(s.y.allFinite());
      ASSERT_LT((s.y - want).norm() / want.norm(), 10.0 * kEps * condition) << "1e" << power;
    }
  }
}

/// tests/report/STUDY.md#large-residual: 72 x 24, cond 1e4, residual 10 % of b.
TEST(Householder, SolvesALargeSystemTo1em10) {
  std::mt19937_64 random(11);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::MatrixXd A = with_condition(random, 72, 24, 1e4);
    const Eigen::VectorXd want = gaussian(random, 24, 1);
    Eigen::VectorXd aside = gaussian(random, 72, 1);
    const Eigen::MatrixXd Q = oracle::orthonormal_basis(A);
    for (int pass = 0; pass < 2; ++pass) aside -= Q * (Q.transpose() * aside);
    const Eigen::VectorXd fits = A * want;
    const Solved s = solve(A, fits + 0.1 * fits.norm() / aside.norm() * aside);
    EXPECT_LT((s.y - want).norm() / want.norm(), 1e-10);
  }
}

TEST(Householder, DiagonalIsRelativeToTheColumns) {
  std::mt19937_64 random(5);
  for (const Size& size : kSizes) {
    const Solved s = solve(gaussian(random, size.m, size.n), gaussian(random, size.m, 1));
    double want = 1.0;
    for (int k = 0; k < size.n; ++k) {  // in the form of the book, with R itself
      want = std::max(want, s.norm2[k] / (s.R(k, k) * s.R(k, k)));
    }
    EXPECT_NEAR(s.condition2 / want, 1.0, 1e-13) << size.m << " x " << size.n;
  }
}

TEST(Householder, DiagonalShowsBadColumns) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  std::mt19937_64 random(4);
  for (const Size& size : kSizes) {
    const Eigen::VectorXd b = gaussian(random, size.m, 1);
    Eigen::MatrixXd zero = gaussian(random, size.m, size.n);
    zero.col(size.n - 1).setZero();
    EXPECT_EQ(solve(zero, b).condition2, kInfinite);
    Eigen::MatrixXd broken = gaussian(random, size.m, size.n);
    broken(size.m - 1, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(solve(broken, b).condition2, kInfinite);
    broken(size.m - 1, 0) = std::numeric_limits<double>::infinity();
    EXPECT_EQ(solve(broken, b).condition2, kInfinite);
    if (size.n < 2) continue;
    Eigen::MatrixXd twice = gaussian(random, size.m, size.n);
    twice.col(size.n - 1) = -2.5 * twice.col(0);
    EXPECT_GT(solve(twice, b).condition2, 1e28);
  }
}

}  // namespace
}  // namespace haptic::core
