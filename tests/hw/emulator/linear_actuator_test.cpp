/// Against the data sheet's figures, and what every friction must obey.
#include "hw/emulator/linear_actuator.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace haptic::hw::emulator {
namespace {

constexpr double kDt = 1e-4;

/// Drives against a constant force (a hanging weight, N) and returns the steady speed.
double speed_under_load(const ActuatorParameters& p, double u, double load) {
  LinearActuator actuator(p, 0.01);
  actuator.drive(u, true);
  // The linkage is kept where the cell gives just that load.
  double l = 0.01;
  for (int i = 0; i < 10000; ++i) {
    l = actuator.x() - 0.5 * p.backlash - load / p.cell_stiffness;
    actuator.step(kDt, l, actuator.v());
  }
  return actuator.v();
}

TEST(LinearActuator, RunsAtTheDataSheetsSpeeds) {
  const ActuatorParameters p;
  const double full = p.stall_force + p.friction;
  // Little load: what is needed to keep the cell pressed.
  EXPECT_NEAR(speed_under_load(p, full, 0.01), 0.032, 2e-4);
  // Peak power points, 1 N below, where the current limit stands.
  EXPECT_NEAR(speed_under_load(p, full, 49.0), 0.016, 5e-4);
}

TEST(LinearActuator, TheCurrentLimitBoundsTheLift) {
  const ActuatorParameters p;
  EXPECT_LE(speed_under_load(p, 1e9, 51.0), 0.0);
}

/// Presses against a wall at l and returns the force at rest.
double force_against_wall(LinearActuator& actuator, double u, double l) {
  actuator.drive(u, true);
  for (int i = 0; i < 20000; ++i) actuator.step(kDt, l, 0.0);
  return actuator.force();
}

TEST(LinearActuator, AWallForceMatchesTheDrive) {
  LinearActuator actuator({}, 0.010);
  const double force = force_against_wall(actuator, 50.0, 0.010);
  EXPECT_LE(force, 50.0 - 31.0 + 1.0);
  EXPECT_GE(force, 50.0 - 31.0 - 1.0);
}

TEST(LinearActuator, SwitchedOffItHolds) {
  LinearActuator actuator({}, 0.020);
  actuator.drive(0.0, false);
  // 30 N in the cell: below the back-drive force of 31 N.
  const double x = actuator.x();
  for (int i = 0; i < 10000; ++i) {
    actuator.step(kDt, x + 0.5 * 0.00025 + 30.0 / 5e4, 0.0);
  }
  EXPECT_NEAR(actuator.force(), -30.0, 1e-9);
  EXPECT_EQ(actuator.x(), x);
  for (int i = 0; i < 10000; ++i) actuator.step(kDt, x + 0.5 * 0.00025 + 40.0 / 5e4, 0.0);
  EXPECT_GT(actuator.x(), x);
  // It gives way until friction holds it again: at 31 N, or as far below as it swung past that.
  EXPECT_GE(actuator.force(), -31.0);
  EXPECT_LE(actuator.force(), -31.0 + (40.0 - 31.0));
}

TEST(LinearActuator, HasItsBacklash) {
  LinearActuator actuator({}, 0.020);
  actuator.step(kDt, 0.020 + 0.000124, 0.0);
  EXPECT_EQ(actuator.force(), 0.0);
  actuator.step(kDt, 0.020 - 0.000124, 0.0);
  EXPECT_EQ(actuator.force(), 0.0);
  actuator.step(kDt, 0.020 - 0.000135, 0.0);
  EXPECT_NEAR(actuator.force(), 5e4 * 1e-5, 1e-6);
}

TEST(LinearActuator, StaysWithinItsStroke) {
  LinearActuator actuator({}, 0.045);
  actuator.drive(100.0, true);
  for (int i = 0; i < 10000; ++i) actuator.step(kDt, actuator.x(), actuator.v());
  EXPECT_EQ(actuator.x(), 0.050);
  EXPECT_EQ(actuator.v(), 0.0);
}

TEST(LinearActuator, StalledItHoldsAndGivesNothing) {
  LinearActuator actuator({}, 0.010);
  actuator.stall(true);
  EXPECT_EQ(force_against_wall(actuator, 100.0, 0.010), 0.0);
  EXPECT_EQ(actuator.x(), 0.010);
}

TEST(LinearActuator, FrictionNeverGivesEnergy) {
  LinearActuator actuator({}, 0.020);
  actuator.drive(0.0, false);
  double work = 0.0;  // of the hand on the rod, through the cell
  for (int i = 0; i < 50000; ++i) {
    const double l = 0.020 + 0.002 * std::sin(0.0005 * i);
    actuator.step(kDt, l, 0.002 * 0.0005 / kDt * std::cos(0.0005 * i));
    work -= actuator.force() * actuator.v() * kDt;
    ASSERT_GE(work, -1e-3) << i;
  }
  EXPECT_GT(work, 0.01);
}

}  // namespace
}  // namespace haptic::hw::emulator
