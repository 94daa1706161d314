#include "haptic/core/control/admittance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "haptic/core/error.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::core {
namespace {

constexpr double kDt = 1e-3;
constexpr AdmittanceParameters kWide{0.0, 100.0, 1.0, -10.0, 10.0};

TEST(Admittance, SwitchingOnMovesNothing) {
  Admittance admittance(kWide);
  admittance.reset(0.03);
  EXPECT_EQ(admittance.step(5.0, 5.0, kDt), 0.03);
}

TEST(Admittance, ConstantErrorGivesTheDampersSpeed) {
  Admittance admittance(kWide);
  admittance.reset(0.0);
  for (int i = 0; i < 1000; ++i) static_cast<void>(admittance.step(3.0, 1.0, kDt));
  EXPECT_NEAR(admittance.position(), 2.0 / 100.0 * 1.0, 1e-12);
}

TEST(Admittance, MassDelaysByItsTimeConstant) {
  Admittance admittance({10.0, 100.0, 1.0, -10.0, 10.0});
  admittance.reset(0.0);
  for (int i = 0; i < 100; ++i) static_cast<void>(admittance.step(2.0, 0.0, kDt));  // m/d = 0.1 s
  EXPECT_NEAR(admittance.rate(), 2.0 / 100.0 * (1.0 - std::exp(-1.0)), 1e-4);
}

TEST(Admittance, SettlesAtTheReference) {
  Admittance admittance({0.5, 100.0, 1.0, 0.0, 0.05});
  admittance.reset(0.01);
  const double k = 2000.0;
  double force = 0.0;
  for (int i = 0; i < 5000; ++i) force = k * (admittance.step(12.0, force, kDt) - 0.01);
  EXPECT_NEAR(force, 12.0, 1e-6);
}

TEST(Admittance, KeepsTheActuatorsRateAndTravel) {
  Admittance admittance({0.0, 1.0, 0.032, 0.0, 0.05});
  admittance.reset(0.0);
  double last = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const double x = admittance.step(1000.0, 0.0, kDt);
    EXPECT_LE(x - last, 0.032 * kDt + 1e-15);
    EXPECT_LE(x, 0.05);
    EXPECT_TRUE(admittance.limited());
    last = x;
  }
  EXPECT_EQ(last, 0.05);
}

TEST(Admittance, LeavesAStopWhenForceTurns) {
  Admittance admittance({10.0, 1.0, 1.0, 0.0, 0.05});
  admittance.reset(0.05);
  for (int i = 0; i < 10000; ++i) static_cast<void>(admittance.step(50.0, 0.0, kDt));
  EXPECT_LT(admittance.step(-1.0, 0.0, kDt), 0.05);
}

TEST(Admittance, NonFiniteForceStopsTheMotion) {
  Admittance admittance({10.0, 1.0, 1.0, -1.0, 1.0});
  admittance.reset(0.0);
  const double x = admittance.step(5.0, 0.0, kDt);
  EXPECT_EQ(admittance.step(5.0, std::numeric_limits<double>::quiet_NaN(), kDt), x);
  EXPECT_EQ(admittance.rate(), 0.0);
}

TEST(Admittance, NamesTheForbiddenParameter) {
  EXPECT_EQ(haptic::test::message_of<SceneError>([] {
              return Admittance({0.0, 0.0, 1.0, 0.0, 1.0});
            }),
            "admittance.damping = 0.000000: must be finite and > 0");
  EXPECT_THROW(Admittance({-1.0, 1.0, 1.0, 0.0, 1.0}), SceneError);
  EXPECT_THROW(Admittance({0.0, 1.0, 1.0, 1.0, 1.0}), SceneError);
}

}  // namespace
}  // namespace haptic::core
