#include "haptic/core/linear/least_squares.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "haptic/core/linear/minimum_norm.hpp"
#include "tests/core/linear/random_matrix.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

using samples::gaussian;
using samples::with_condition;

DofLayout layout_of(int n_q, int n_a) {
  bool actuated[kMaxQ]{};
  std::fill(actuated, actuated + n_a, true);
  return DofLayout(std::span<const bool>(actuated, static_cast<std::size_t>(n_q)));
}

Eigen::VectorXd by_us(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, const Eigen::VectorXd& M,
                      int* rank = nullptr) {
  Eigen::MatrixXd scaled = A * M.cwiseSqrt().cwiseInverse().asDiagonal();
  Eigen::VectorXd rhs = b, y(A.cols());
  const int r = minimum_norm(scaled.data(), rhs.data(), static_cast<int>(A.rows()),
                             static_cast<int>(A.cols()), 1e-8, y.data());
  if (rank != nullptr) *rank = r;
  return y.cwiseQuotient(M.cwiseSqrt());
}

TEST(LeastSquares, OneFactorisationGivesAllThreeForces) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const int n_q = 1 + trial % 6, n_a = 1 + trial % n_q, n_x = n_q + trial % 4;
    const Eigen::MatrixXd J = gaussian(random, n_x, n_q);
    const Eigen::VectorXd dx = gaussian(random, n_x, 1);
    LeastSquares solver(n_x, layout_of(n_q, n_a));
    solver.solve(J, dx, VecA::Ones(n_a));
    const double condition = oracle::condition(J);
    if (condition > 1e4) continue;
    ASSERT_EQ(solver.status(), ProjectionStatus::kExact);
    const double tolerance = 1e-14 * condition * condition * (1.0 + J.norm() * dx.norm());
    const Eigen::MatrixXd J_a = J.leftCols(n_a), J_n = J.rightCols(n_q - n_a);
    Eigen::VectorXd f = dx;
    if (n_q > n_a) f -= J_n * oracle::least_squares(J_n, dx);
    ASSERT_LT((solver.null_space_force() - J_a.transpose() * f).norm(), tolerance);
    const Eigen::VectorXd dq = oracle::least_squares(J, dx);
    ASSERT_LT((solver.dq() - dq).norm(), tolerance * (1.0 + dq.norm()));
    ASSERT_NEAR(solver.residual(), (dx - J * dq).norm(), tolerance);
  }
}

/// tests/report/STUDY.md#condition-sweep: flagged above 1e8. The diagonal of R overestimates the
/// smallest singular value by a small factor, so the decade around the limit belongs to neither
/// side.
TEST(LeastSquares, ReportsIllConditioningAboveTheLimit) {
  std::mt19937_64 random(10);
  for (int power = 0; power <= 16; ++power) {
    if (power == 8 || power == 9) continue;
    for (int trial = 0; trial < 40; ++trial) {
      const Eigen::MatrixXd J = with_condition(random, 6, 6, std::pow(10.0, power));
      LeastSquares solver(6, layout_of(6, 3));
      solver.solve(J, gaussian(random, 6, 1), VecA::Ones(3));
      ASSERT_TRUE(solver.dq().allFinite());
      ASSERT_EQ(solver.status() == ProjectionStatus::kExact, power < 8) << "1e" << power;
      ASSERT_EQ(solver.condition() > 1e8, power > 8) << "1e" << power;
    }
  }
}

/// tests/report/STUDY.md#rank-loss: a zero column, a repeated column, fewer rows than columns.
TEST(MinimumNorm, IsSmallestInItsMetric) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> power(-3.0, 3.0);
  for (int trial = 0; trial < 3000; ++trial) {
    const int n = 2 + trial % 6;
    const int kind = trial % 3;
    const int m = kind == 2 ? n - 1 : n + trial % 3;
    Eigen::MatrixXd J = gaussian(random, m, n);
    if (kind == 0) J.col(trial % n).setZero();
    if (kind == 1) J.col((trial + 1) % n) = J.col(trial % n);
    Eigen::VectorXd M(n);
    for (int i = 0; i < n; ++i) M[i] = std::pow(10.0, 0.3 * power(random));
    const Eigen::VectorXd dx = gaussian(random, m, 1);
    const Eigen::VectorXd want = oracle::least_squares_in_metric(J, dx, M, 1e-8);
    const Eigen::VectorXd singular = oracle::singular_values(J);
    const int full = static_cast<int>((singular.array() > 1e-10 * singular[0]).count());
    if (singular[full - 1] < 1e-2 * singular[0])
      continue;  // the case is rank loss, not nearness to it
    int rank = 0;
    const Eigen::VectorXd got = by_us(J, dx, M, &rank);
    ASSERT_EQ(rank, full);
    ASSERT_LT((got - want).norm(), 1e-12 * (1.0 + want.norm()) * 10) << J;
    // The reachable part of dx, which any correct answer shares.
    ASSERT_LT((J * got - J * oracle::least_squares(J, dx)).norm(), 1e-12 * 10);
    // No part of it lies in the null space, M-orthogonally: a zero residual would not show that.
    const Eigen::MatrixXd kernel = oracle::null_space(J);
    ASSERT_LT((kernel.transpose() * M.asDiagonal() * got).norm(),
              1e-11 * kernel.norm() * M.norm() * (1.0 + got.norm()));
  }
}

/// Z_q S J^+ J S^T column by column: what the actuators feel per unit of their own motion.
template <typename Solve>
Eigen::Matrix2d displayed(const Eigen::MatrixXd& J, const Eigen::Vector2d& Z_q, Solve solve) {
  Eigen::Matrix2d K;
  for (int i = 0; i < 2; ++i) {
    K.col(i) = Z_q.asDiagonal() * Eigen::Vector2d(solve(J.col(i)).head(2));
  }
  return K;
}

double smallest_symmetric(const Eigen::Matrix2d& K) {
  return oracle::smallest_eigenvalue(0.5 * (K + K.transpose()));
}

/// tests/report/STUDY.md#unequal-stiffness: with the unit metric Z_q > 0 is no promise of
/// passivity; with Z_q as the metric of its own block it is.
TEST(MinimumNorm, ActuatedBlocksMetricMustBeZq) {
  Eigen::MatrixXd J(2, 4);
  J << .125730, -.132105, .640423, .104900, -.535669, .361595, 1.304000, .947081;
  struct Row {
    double r, smallest, tolerance;
  };
  for (const Row& row :
       {Row{1, .0013, 5e-5}, Row{10, -.60, 5e-3}, Row{100, -7.7, 5e-2}, Row{1000, -79, 0.5}}) {
    const Eigen::Vector2d Z_q(1.0, row.r);
    const Eigen::Matrix2d unit = displayed(
        J, Z_q, [&](const Eigen::VectorXd& dx) { return by_us(J, dx, Eigen::VectorXd::Ones(4)); });
    EXPECT_NEAR(smallest_symmetric(unit), row.smallest, row.tolerance) << "r = " << row.r;
    LeastSquares solver(2, layout_of(4, 2));
    const Eigen::Matrix2d ours = displayed(J, Z_q, [&](const Eigen::VectorXd& dx) {
      solver.solve(J, dx, Z_q);
      EXPECT_EQ(solver.status(), ProjectionStatus::kRankDeficient);
      return Eigen::VectorXd(solver.dq());
    });
    EXPECT_LT((ours - ours.transpose()).norm(), 1e-12 * ours.norm());
    EXPECT_GE(smallest_symmetric(ours), -1e-12 * ours.norm()) << "r = " << row.r;
  }
}

TEST(LeastSquares, AnswersAreFinite) {
  constexpr double kBad[] = {std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity(), 1e200, 1e-200, 0.0};
  std::mt19937_64 random(5);
  for (int n_x : {1, 2, 4, 6}) {
    for (int trial = 0; trial < 500; ++trial) {
      const int n_q = 1 + trial % 6;
      Eigen::MatrixXd J = gaussian(random, n_x, n_q);
      Eigen::VectorXd dx = gaussian(random, n_x, 1);
      J(trial % n_x, (trial / 7) % n_q) = kBad[trial % 5];
      if (trial % 3 == 0) J.col(trial % n_q) *= kBad[trial % 5];
      if (trial % 11 == 0) dx[trial % n_x] = kBad[trial % 5];
      LeastSquares solver(n_x, layout_of(n_q, 1 + trial % n_q));
      solver.solve(J, dx, VecA::Constant(1 + trial % n_q, 500.0));
      ASSERT_TRUE(solver.dq().allFinite()) << J;
      ASSERT_TRUE(solver.null_space_force().allFinite()) << J;
      ASSERT_FALSE(std::isnan(solver.residual())) << J;
    }
  }
}

}  // namespace
}  // namespace haptic::core
