#include "haptic/core/control/force_loop.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic/core/error.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::core {
namespace {

constexpr double kTick = 1e-4;

/// A geared actuator against a spring: D v = u - F - d, F_dot = k v. With a = k / D: F_dot = a (u -
/// F - d).
struct GearedPlant {
  double a{20.0};  ///< 1/s
  double d{0.0};   ///< N, a disturbance
  double F{0.0};   ///< N, what the load cell measures
  void step(double u) { F += kTick * a * (u - F - d); }
};

TEST(ForceLoop, ProportionalGainShortensTheTimeConstant) {
  // F_dot = a (r + K_P (r - F) - F) = a (1 + K_P)(r - F).
  ForceLoop loop({4.0, 0.0, 0.0, 1.0, 1e6});
  GearedPlant plant;
  const double time_constant = 1.0 / (plant.a * 5.0);
  for (int i = 0; i < static_cast<int>(std::lround(time_constant / kTick)); ++i) {
    plant.step(loop.step(10.0, plant.F, kTick));
  }
  EXPECT_NEAR(plant.F, 10.0 * (1.0 - std::exp(-1.0)), 0.03);  // of first order in dt
}

TEST(ForceLoop, IntegralRemovesAConstantDisturbance) {
  GearedPlant plant{20.0, 6.0, 0.0};
  ForceLoop without({4.0, 0.0, 0.0, 1.0, 1e3});
  for (int i = 0; i < 50000; ++i) plant.step(without.step(10.0, plant.F, kTick));
  EXPECT_NEAR(plant.F, 10.0 - 6.0 / 5.0, 1e-9);  // d / (1 + K_P) is left
  ForceLoop with({4.0, 80.0, 0.0, 1.0, 1e3});
  for (int i = 0; i < 50000; ++i) plant.step(with.step(10.0, plant.F, kTick));
  EXPECT_NEAR(plant.F, 10.0, 1e-9);
  EXPECT_NEAR(with.integral(), 6.0, 1e-9);
}

TEST(ForceLoop, FrictionFeedforwardFollowsTheErrorsSign) {
  const auto u = [](double e) {
    ForceLoop loop({0.0, 0.0, 5.0, 0.5, 100.0});
    return loop.step(0.0, -e, kTick);
  };
  EXPECT_EQ(u(0.0), 0.0);
  EXPECT_DOUBLE_EQ(u(0.25), 2.5);
  EXPECT_DOUBLE_EQ(u(3.0), 5.0);
  EXPECT_DOUBLE_EQ(u(-3.0), -5.0);
}

TEST(ForceLoop, TheOutputStaysWithinItsLimit) {
  ForceLoop loop({10.0, 100.0, 5.0, 0.5, 20.0});
  for (int i = 0; i < 1000; ++i) {
    EXPECT_LE(std::abs(loop.step(40.0 * std::sin(0.1 * i), 0.0, 1e-3)), 20.0);
  }
}

TEST(ForceLoop, SaturationLeavesNoWindup) {
  const auto first_after = [](int saturated_steps) {
    ForceLoop loop({2.0, 50.0, 0.0, 1.0, 20.0});
    for (int i = 0; i < saturated_steps; ++i) static_cast<void>(loop.step(30.0, 0.0, 1e-3));
    EXPECT_TRUE(loop.saturated());
    return loop.step(5.0, 8.0, 1e-3);
  };
  EXPECT_LT(first_after(10), 20.0);
  EXPECT_EQ(first_after(10), first_after(100000));
}

TEST(ForceLoop, WithinLimitsItIsPlainPI) {
  ForceLoop loop({2.0, 50.0, 0.0, 1.0, 1e6});
  double integral = 0.0;
  for (int i = 0; i < 100; ++i) {
    const double reference = 3.0 + i % 7, measured = i % 5;
    integral += 50.0 * (reference - measured) * 1e-3;
    EXPECT_NEAR(loop.step(reference, measured, 1e-3),
                reference + 2.0 * (reference - measured) + integral, 1e-12);
  }
}

TEST(ForceLoop, NonFiniteMeasurementStopsOneStep) {
  ForceLoop loop({2.0, 50.0, 0.0, 1.0, 20.0});
  static_cast<void>(loop.step(1.0, 0.0, 1e-3));
  const double before = loop.integral();
  EXPECT_EQ(loop.step(1.0, std::numeric_limits<double>::quiet_NaN(), 1e-3), 0.0);
  EXPECT_EQ(loop.integral(), before);
  EXPECT_GT(loop.step(1.0, 0.0, 1e-3), 1.0);
}

TEST(ForceLoop, UChangesByItsBound) {
  ForceLoop loop({20.0, 100.0, 15.0, 0.5, 38.0});
  double before = 0.0, largest = 0.0;
  for (int i = 0; i < 200; ++i) {
    const double u = loop.step(3.0, i % 2 == 0 ? 60.0 : -60.0, 1e-3, {.change = 2.0});
    EXPECT_LE(std::abs(u - before), 2.0 + 1e-12);
    largest = std::max(largest, std::abs(u - before));
    before = u;
  }
  EXPECT_NEAR(largest, 2.0, 1e-12);
  EXPECT_TRUE(loop.slewed());
}

TEST(ForceLoop, SlewedLoopsDoNotWindUp) {
  ForceLoop loop({2.0, 50.0, 0.0, 1.0, 40.0});
  for (int i = 0; i < 1000; ++i) static_cast<void>(loop.step(9.0, 0.0, 1e-3, {.change = 0.001}));
  EXPECT_NEAR(loop.integral(), 0.0, 1e-12) << "u = 1 N of the 27 that it wants";
  EXPECT_FALSE(loop.saturated());
}

TEST(ForceLoop, ANarrowerForceBoundsU) {
  ForceLoop loop({2.0, 50.0, 0.0, 1.0, 20.0});
  EXPECT_EQ(loop.step(30.0, 0.0, 1e-3, {.force = 7.0}), 7.0);
  EXPECT_TRUE(loop.saturated());
  EXPECT_EQ(loop.step(30.0, 0.0, 1e-3, {.force = 40.0}), 20.0) << "its own limit stays";
}

TEST(ForceLoop, AnEndingForceEndsInTime) {
  const ForceLoopGains plain{0.0, 0.0, 0.0, 1.0, 20.0};
  for (const double sign : {1.0, -1.0}) {
    ForceLoop loop(plain);
    EXPECT_EQ(loop.step(sign * 10.0, 0.0, 1e-3), sign * 10.0);
    const DriveBounds ending{.change = 1e-9, .excess = 4.0};
    EXPECT_EQ(loop.step(sign * 1.0, 0.0, 1e-3, ending), sign * 5.0);
    EXPECT_EQ(loop.step(-sign * 1.0, 0.0, 1e-3, ending), sign * 4.0) << "0, and the excess";
    EXPECT_EQ(loop.step(0.0, 0.0, 1e-3, {.change = 1e-9, .excess = 0.0}), 0.0);
  }
}

TEST(ForceLoop, ForgettingKeepsWhatTheDriveGives) {
  ForceLoop loop({0.0, 50.0, 0.0, 1.0, 20.0});
  for (int i = 0; i < 100; ++i) static_cast<void>(loop.step(1.0, 0.0, 1e-3));
  ASSERT_NEAR(loop.integral(), 5.0, 1e-12);
  loop.forget();
  EXPECT_NEAR(loop.step(1.0, 1.0, 1e-3, {.change = 0.5}), 5.5, 1e-12) << "6 N before";
}

TEST(ForceLoop, ResetForgetsTheIntegral) {
  ForceLoop loop({0.0, 50.0, 0.0, 1.0, 20.0});
  static_cast<void>(loop.step(1.0, 0.0, 1e-3));
  loop.reset();
  EXPECT_EQ(loop.step(2.0, 2.0, 1e-3), 2.0);
}

TEST(ForceLoop, NamesTheForbiddenGain) {
  EXPECT_EQ(haptic::test::message_of<SceneError>([] {
              return ForceLoop({-1.0, 0.0, 0.0, 1.0, 1.0});
            }),
            "force_loop.proportional = -1.000000: must be finite and >= 0");
  EXPECT_THROW(ForceLoop({0.0, 0.0, 0.0, 0.0, 1.0}), SceneError);
  EXPECT_THROW(ForceLoop({0.0, 0.0, 0.0, 1.0, 0.0}), SceneError);
  EXPECT_THROW(ForceLoop({0.0, std::numeric_limits<double>::infinity(), 0.0, 1.0, 1.0}),
               SceneError);
}

}  // namespace
}  // namespace haptic::core
