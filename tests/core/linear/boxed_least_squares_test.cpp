#include "haptic/core/linear/boxed_least_squares.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "tests/core/linear/random_matrix.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

using samples::gaussian;

double cost(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, const Eigen::VectorXd& p) {
  return (b - A * p).squaredNorm();
}

/// The least cost over all 3^n ways of fixing coordinates, those that end inside.
double by_enumeration(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                      const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) {
  const int n = static_cast<int>(A.cols());
  double best = std::numeric_limits<double>::infinity();
  const int ways = static_cast<int>(std::lround(std::pow(3.0, n)));
  for (int way = 0; way < ways; ++way) {
    Eigen::VectorXd p = Eigen::VectorXd::Zero(n);
    std::vector<int> free;
    for (int k = 0, rest = way; k < n; ++k, rest /= 3) {
      if (rest % 3 == 0) free.push_back(k);
      if (rest % 3 == 1) p[k] = lower[k];
      if (rest % 3 == 2) p[k] = upper[k];
    }
    if (!free.empty()) {
      const Eigen::MatrixXd F = A(Eigen::all, free);
      const Eigen::VectorXd y = oracle::least_squares(F, b - A * p);
      for (std::size_t k = 0; k < free.size(); ++k) p[free[k]] = y[static_cast<int>(k)];
    }
    if ((p - lower).minCoeff() < -1e-12 || (upper - p).minCoeff() < -1e-12) continue;
    best = std::min(best, cost(A, b, p));
  }
  return best;
}

void load(BoxedLeastSquares& problem, const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  problem.begin(static_cast<int>(A.rows()), static_cast<int>(A.cols()));
  problem.add(A, b);
}

TEST(BoxedLeastSquares, BeatsEveryChoiceOfFixedCoordinates) {
  std::mt19937_64 random(1);
  BoxedLeastSquares problem;
  int limited = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const int n = 1 + trial % 5, m = n + trial % 3;
    const Eigen::MatrixXd A = gaussian(random, m, n);
    const Eigen::VectorXd b = 2.0 * gaussian(random, m, 1);
    VecQ lower = -gaussian(random, n, 1).cwiseAbs(), upper = gaussian(random, n, 1).cwiseAbs();
    if (trial % 4 == 0) lower[trial % n] = 0.0;  // the start is on a limit
    load(problem, A, b);
    problem.solve(lower, upper, VecQ::Ones(n));
    const VecQ p = problem.p();
    ASSERT_GE((p - lower).minCoeff(), 0.0);
    ASSERT_GE((upper - p).minCoeff(), 0.0);
    const double best = by_enumeration(A, b, lower, upper);
    ASSERT_NEAR(cost(A, b, p), best, 1e-10 * (1.0 + best)) << A << "\n" << b.transpose();
    ASSERT_NEAR(problem.residual2(), cost(A, b, p), 1e-12 * (1.0 + best));
    limited += problem.limited();
  }
  EXPECT_GT(limited, 300);
  EXPECT_LT(limited, 1400);
}

/// Larger, with prior and damping rows: no coordinate that could still lower the cost.
TEST(BoxedLeastSquares, MeetsMinimumConditionsAtEverySize) {
  std::mt19937_64 random(2);
  BoxedLeastSquares problem;
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 2 + trial % (kMaxQ - 1), m = 1 + trial % kMaxX;
    const MatXQ J = gaussian(random, m, n);
    const VecX r = 3.0 * gaussian(random, m, 1);
    const VecQ weight = gaussian(random, n, 1).cwiseAbs(), target = gaussian(random, n, 1);
    problem.begin(m + 2 * n, n);
    problem.add(J, r);
    problem.add_diagonal(weight, target);
    problem.add_diagonal(VecQ::Constant(n, 0.1), VecQ::Zero(n));
    const VecQ lower = -0.3 * gaussian(random, n, 1).cwiseAbs();
    const VecQ upper = 0.3 * gaussian(random, n, 1).cwiseAbs();
    problem.solve(lower, upper, VecQ::Ones(n));
    const Eigen::VectorXd p = problem.p();
    const Eigen::VectorXd slope =  // minus the gradient of half the cost
        J.transpose() * (r - J * p) +
        Eigen::VectorXd(weight.cwiseAbs2().cwiseProduct(target - problem.p())) - 0.01 * p;
    const double tolerance = 1e-9 * (1.0 + J.norm() * r.norm());
    for (int k = 0; k < n; ++k) {
      ASSERT_GE(p[k], lower[k]);
      ASSERT_LE(p[k], upper[k]);
      ASSERT_TRUE(p[k] >= upper[k] || slope[k] < tolerance) << "could grow";
      ASSERT_TRUE(p[k] <= lower[k] || slope[k] > -tolerance) << "could shrink";
    }
  }
}

TEST(BoxedLeastSquares, MetricDecidesDependentColumns) {
  BoxedLeastSquares problem;
  load(problem, (Eigen::MatrixXd(2, 2) << 1, 1, 1, 1).finished(), Eigen::Vector2d(2, 2));
  // ||p||_M with M = diag(1, 4): p = (1.6, 0.4) of all p with p_0 + p_1 = 2.
  const VecQ far = VecQ::Constant(2, 10.0);
  problem.solve(-far, far, (VecQ(2) << 1.0, 0.5).finished());
  EXPECT_NEAR(problem.p()[0], 1.6, 1e-14);
  EXPECT_NEAR(problem.p()[1], 0.4, 1e-14);
  EXPECT_EQ(problem.status(), ProjectionStatus::kRankDeficient);
  // With the first held at 1 the other makes up for it, and nothing is in doubt any more.
  problem.solve(-far, (VecQ(2) << 1.0, 10.0).finished(), (VecQ(2) << 1.0, 0.5).finished());
  EXPECT_NEAR(problem.p()[0] + problem.p()[1], 2.0, 1e-14);
  EXPECT_EQ(problem.p()[0], 1.0);
  EXPECT_EQ(problem.status(), ProjectionStatus::kExact);
}

TEST(BoxedLeastSquares, NonFiniteInputMovesNothing) {
  BoxedLeastSquares problem;
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const VecQ one = VecQ::Ones(2);
    load(problem, Eigen::Matrix2d::Identity(), Eigen::Vector2d(1.0, bad));
    problem.solve(-one, one, one);
    EXPECT_EQ(problem.p(), VecQ::Zero(2));
    load(problem, (Eigen::Matrix2d() << 1.0, bad, 0.0, 1.0).finished(), Eigen::Vector2d(1.0, 1.0));
    problem.solve(-one, one, one);
    EXPECT_TRUE(problem.p().allFinite());
  }
}

}  // namespace
}  // namespace haptic::core
