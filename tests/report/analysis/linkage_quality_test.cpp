#include "tests/report/analysis/linkage_quality.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/report/analysis/differential_evolution.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core {
namespace {

/// The gradient of q_a(x) by differences of the closed inverse.
TEST(LinkageQuality, IsTheGradientOfTravel) {
  const double h = 1e-5;
  for (const double mcp : {5.0, 40.0, 75.0}) {
    for (const double pip : {5.0, 45.0, 85.0}) {
      const auto travel = [&](double d_mcp, double d_pip) {
        return linkage_node({}, mcp * kDegree + d_mcp, pip * kDegree + d_pip)->l;
      };
      const auto node = linkage_node({}, mcp * kDegree, pip * kDegree);
      ASSERT_TRUE(node);
      EXPECT_NEAR(node->w1, (travel(h, 0) - travel(-h, 0)) / (2 * h), 1e-8);
      EXPECT_NEAR(node->w2, (travel(0, h) - travel(0, -h)) / (2 * h), 1e-8);
    }
  }
}

TEST(LinkageQuality, DefaultNeverTurnsItsSign) {
  const LinkageQuality q = linkage_quality({}, 1.0);
  EXPECT_EQ(q.with_straight, 1.0);
  EXPECT_EQ(q.both_positive, 1.0);
  EXPECT_GT(q.both_strong, 0.97);
  EXPECT_GT(q.w1.lowest, 0.001);
  EXPECT_GT(q.w2.lowest, 0.004);
  EXPECT_LT(q.condition.highest, 15.0);
  EXPECT_GT(q.pivot_height.lowest, -0.010);
}

TEST(DifferentialEvolution, FindsRosenbrocksValley) {
  const auto rosenbrock = [](const std::vector<double>& p) {
    return std::pow(1 - p[0], 2) + 100 * std::pow(p[1] - p[0] * p[0], 2);
  };
  const std::vector<Interval> box{{-5, 5}, {-5, 5}};
  const Evolution evolution{.population = 40, .generations = 300};
  const std::vector<double> best = minimise(rosenbrock, box, evolution);
  EXPECT_NEAR(best[0], 1.0, 1e-6);
  EXPECT_NEAR(best[1], 1.0, 1e-6);
  EXPECT_EQ(minimise(rosenbrock, box, evolution), best) << "the same seed";
}

}  // namespace
}  // namespace haptic::core
