#include "hw/motion/pchip.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace haptic::hw {
namespace {

TEST(Pchip, GoesThroughItsKnots) {
  const Pchip curve({0.0, 0.1, 0.5, 2.0}, {1.0, -3.0, 4.0, 4.5});
  EXPECT_DOUBLE_EQ(curve(0.0), 1.0);
  EXPECT_NEAR(curve(0.1), -3.0, 1e-15);
  EXPECT_NEAR(curve(0.5), 4.0, 1e-15);
  EXPECT_DOUBLE_EQ(curve(2.0), 4.5);
}

TEST(Pchip, HoldsItsEndsOutside) {
  const Pchip curve({1.0, 2.0, 3.0}, {5.0, 7.0, 6.0});
  EXPECT_EQ(curve(-10.0), 5.0);
  EXPECT_EQ(curve(99.0), 6.0);
}

TEST(Pchip, AStraightLineStaysStraight) {
  const Pchip curve({0.0, 0.3, 1.0, 1.1}, {1.0, 1.6, 3.0, 3.2});
  for (double t = 0.0; t <= 1.1; t += 0.01) EXPECT_NEAR(curve(t), 1.0 + 2.0 * t, 1e-14);
}

TEST(Pchip, TwoRowsAreALine) {
  EXPECT_NEAR(Pchip({0.0, 2.0}, {1.0, 5.0})(0.5), 2.0, 1e-15);
  EXPECT_EQ(Pchip({0.0}, {7.0})(0.0), 7.0);
}

TEST(Pchip, StaysBetweenNeighbouringKnots) {
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  std::vector<double> t{0.0}, y{0.0};
  for (int i = 1; i < 300; ++i) {
    t.push_back(t.back() + 0.001 + 0.05 * std::abs(random(generator)));
    y.push_back(i % 7 == 0 ? y.back() : random(generator) * (i % 5 == 0 ? 100.0 : 1.0));
  }
  const Pchip curve(t, y);
  for (std::size_t i = 0; i + 1 < t.size(); ++i) {
    const auto [low, high] = std::minmax(y[i], y[i + 1]);
    for (int k = 1; k < 20; ++k) {
      const double value = curve(t[i] + (t[i + 1] - t[i]) * k / 20.0);
      EXPECT_GE(value, low - 1e-12);
      EXPECT_LE(value, high + 1e-12);
    }
  }
}

TEST(Pchip, HasAContinuousSlope) {
  const Pchip curve({0.0, 0.1, 0.3, 0.4, 0.9}, {0.0, 0.2, 0.3, 0.9, 1.0});
  constexpr double h = 1e-7;
  for (const double knot : {0.1, 0.3, 0.4}) {
    const double before = (curve(knot) - curve(knot - h)) / h;
    const double after = (curve(knot + h) - curve(knot)) / h;
    EXPECT_NEAR(before, after, 1e-4);
  }
}

TEST(Pchip, ConvergesToASmoothMotion) {
  // Monotone quarter of a sine: the error falls with the square of the spacing or faster.
  const auto worst = [](int n) {
    std::vector<double> t, y;
    for (int i = 0; i <= n; ++i) {
      t.push_back(1.5 * i / n);
      y.push_back(std::sin(t.back()));
    }
    const Pchip curve(t, y);
    double error = 0.0;
    for (double s = 0.0; s <= 1.5; s += 0.001) {
      error = std::max(error, std::abs(curve(s) - std::sin(s)));
    }
    return error;
  };
  EXPECT_LT(worst(20), 2e-4);
  EXPECT_LT(worst(40), 0.3 * worst(20));
}

TEST(Pchip, FindsTheIntervalAroundATime) {
  const Pchip curve({0.0, 1.0, 2.0, 3.0}, {0.0, 0.0, 0.0, 0.0});
  EXPECT_EQ(curve.interval(-1.0), 0u);
  EXPECT_EQ(curve.interval(0.5), 0u);
  EXPECT_EQ(curve.interval(1.0), 1u);
  EXPECT_EQ(curve.interval(2.999), 2u);
  EXPECT_EQ(curve.interval(3.0), 2u);
  EXPECT_EQ(curve.interval(30.0), 2u);
}

}  // namespace
}  // namespace haptic::hw
