#include "haptic/core/linear/boxed_least_squares.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "tests/core/linear/random_matrix.hpp"

namespace haptic::core {
namespace {

using samples::gaussian;

void load(BoxedLeastSquares& problem, const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  problem.begin(static_cast<int>(A.rows()), static_cast<int>(A.cols()));
  problem.add(A, b);
}

/// With prior and damping rows in every other trial: no coordinate could still lower the cost, so
/// it is the minimum of this convex problem.
TEST(BoxedLeastSquares, MeetsMinimumConditionsAtEverySize) {
  std::mt19937_64 random(2);
  BoxedLeastSquares problem;
  int limited = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const int n = 2 + trial % (kMaxQ - 1), m = 1 + trial % kMaxX;
    const MatXQ J = gaussian(random, m, n);
    const VecX r = 3.0 * gaussian(random, m, 1);
    const VecQ weight = gaussian(random, n, 1).cwiseAbs(), target = gaussian(random, n, 1);
    const bool damped = trial % 2 == 0;
    problem.begin(damped ? m + 2 * n : m, n);
    problem.add(J, r);
    if (damped) {
      problem.add_diagonal(weight, target);
      problem.add_diagonal(VecQ::Constant(n, 0.1), VecQ::Zero(n));
    }
    VecQ lower = -0.3 * gaussian(random, n, 1).cwiseAbs();
    const VecQ upper = 0.3 * gaussian(random, n, 1).cwiseAbs();
    if (trial % 4 == 1) lower[trial % n] = 0.0;  // the start is on a limit
    problem.solve(lower, upper, VecQ::Ones(n));
    const Eigen::VectorXd p = problem.p();
    const Eigen::VectorXd away = weight.cwiseProduct(target - problem.p());
    // Half the cost's gradient, negative.
    Eigen::VectorXd slope = J.transpose() * (r - J * p);
    double cost = (r - J * p).squaredNorm();
    if (damped) {
      slope += Eigen::VectorXd(weight.cwiseProduct(VecQ(away))) - 0.01 * p;
      cost += away.squaredNorm() + 0.01 * p.squaredNorm();
    }
    ASSERT_NEAR(problem.residual2(), cost, 1e-11 * (1.0 + cost));
    limited += problem.limited() ? 1 : 0;
    const double tolerance = 1e-9 * (1.0 + J.norm() * r.norm());
    for (int k = 0; k < n; ++k) {
      ASSERT_GE(p[k], lower[k]);
      ASSERT_LE(p[k], upper[k]);
      ASSERT_TRUE(p[k] >= upper[k] || slope[k] < tolerance) << "could grow";
      ASSERT_TRUE(p[k] <= lower[k] || slope[k] > -tolerance) << "could shrink";
    }
  }
  EXPECT_GT(limited, 300);
  EXPECT_LT(limited, 1500);
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
