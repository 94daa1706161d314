// Expected temperatures are the closed-form solutions of the two bodies' equations.
#include "haptic/core/safety/thermal_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace haptic::core {
namespace {

using std::chrono::milliseconds;

ThermalParameters motor() {
  ThermalParameters p;
  p.motor_constant = 4.0;
  p.winding_resistance = 6.0;
  p.winding_time = 12.0;
  p.housing_resistance = 4.0;
  p.housing_time = 300.0;
  p.ambient_c = 25.0;
  p.derate_from_c = 85.0;
  p.limit_c = 105.0;
  return p;
}

TEST(ThermalModel, SingleWindingWarmsExponentially) {
  ThermalParameters p = motor();
  p.housing_resistance = 0.0;
  ThermalState fine{25.0, 25.0};
  for (int i = 0; i < 20'000; ++i) fine = thermal_step(p, fine, 8.0, milliseconds(1));
  // P = (8 / 4)^2 = 4 W, 24 K at the end, 20 s of a time constant of 12 s, whatever the step.
  const double expected = 25.0 + 24.0 * (1.0 - std::exp(-20.0 / 12.0));
  EXPECT_NEAR(fine.winding_c, expected, 1e-9);
  EXPECT_NEAR(thermal_step(p, {25.0, 25.0}, 8.0, milliseconds(20'000)).winding_c, expected, 1e-9);
}

TEST(ThermalModel, BothBodiesCarryThePowerFinally) {
  const ThermalParameters p = motor();
  ThermalState state{25.0, 25.0};
  for (int i = 0; i < 60'000; ++i) state = thermal_step(p, state, 8.0, milliseconds(100));
  EXPECT_NEAR(state.housing_c, 25.0 + 4.0 * 4.0, 1e-3);          // R_h P
  EXPECT_NEAR(state.winding_c, 25.0 + (4.0 + 6.0) * 4.0, 1e-3);  // (R_h + R_w) P
}

TEST(ThermalModel, ForcesSignDoesNotMatter) {
  const ThermalParameters p = motor();
  const ThermalState pushed = thermal_step(p, {40.0, 30.0}, 5.0, milliseconds(10));
  const ThermalState pulled = thermal_step(p, {40.0, 30.0}, -5.0, milliseconds(10));
  EXPECT_EQ(pushed.winding_c, pulled.winding_c);
}

TEST(ThermalModel, NoAllowedPatternPassesTheLimit) {
  const ThermalParameters p = motor();
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  ThermalState state = unknown_history(p);
  double hottest = 0.0;
  double wanted = 40.0;
  for (int i = 0; i < 2'000'000; ++i) {  // 33 minutes
    if (i % 5000 == 0) wanted = share(random) < 0.8 ? 40.0 : 0.0;
    const double tau = std::min(wanted, thermal_force(p, state, 40.0));
    state = thermal_step(p, state, tau, milliseconds(1));
    hottest = std::max(hottest, state.winding_c);
  }
  EXPECT_LE(hottest, p.limit_c);
  EXPECT_GT(hottest, p.derate_from_c + 5.0) << "the limit was never at work";
}

TEST(ThermalModel, DeratesFromFullToContinuousForce) {
  const ThermalParameters p = motor();
  EXPECT_EQ(thermal_force(p, {p.derate_from_c, 60.0}, 40.0), 40.0);
  const double lasting = 4.0 * std::sqrt(8.0);  // 80 K over 10 K/W
  EXPECT_NEAR(thermal_force(p, {p.limit_c, 60.0}, 40.0), lasting, 1e-12);
  // Power is linear between: at half the way, the mean of 100 W and 8 W.
  EXPECT_NEAR(thermal_force(p, {95.0, 60.0}, 40.0), 4.0 * std::sqrt(54.0), 1e-12);
  EXPECT_EQ(thermal_force(p, {p.limit_c, 60.0}, 5.0), 5.0)
      << "less than continuous is always given";
  EXPECT_NEAR(thermal_force(p, {400.0, 60.0}, 40.0), lasting, 1e-12);
}

TEST(ThermalModel, RestartKeepsAHotMotorHot) {
  const ThermalParameters p = motor();
  const ThermalState start = unknown_history(p);
  EXPECT_EQ(start.winding_c, p.derate_from_c);
  EXPECT_NEAR(start.housing_c, (4.0 * 85.0 + 6.0 * 25.0) / 10.0, 1e-12);
}

TEST(ThermalModel, NamesTheForbiddenParameter) {
  struct Case {
    double ThermalParameters::*field;
    double value;
    const char* named;
  };
  const Case cases[] = {
      {&ThermalParameters::motor_constant, 0.0, "motor_constant"},
      {&ThermalParameters::winding_resistance, -1.0, "winding_resistance"},
      {&ThermalParameters::winding_time, std::nan(""), "winding_time"},
      {&ThermalParameters::housing_resistance, -0.1, "housing_resistance"},
      {&ThermalParameters::housing_time, 0.0, "housing_time"},
      {&ThermalParameters::derate_from_c, 25.0, "derate_from_c"},
      {&ThermalParameters::derate_from_c, 105.0, "derate_from_c"},
      {&ThermalParameters::limit_c, HUGE_VAL, "limit_c"},
  };
  EXPECT_EQ(check(motor()), nullptr);
  for (const Case& c : cases) {
    ThermalParameters p = motor();
    p.*c.field = c.value;
    const char* wrong = check(p);
    ASSERT_NE(wrong, nullptr) << c.named;
    EXPECT_NE(std::string(wrong).find(c.named), std::string::npos) << wrong;
  }
}

}  // namespace
}  // namespace haptic::core
