// core/METHOD.md#forces-at-the-finger and core/METHOD.md#energy-tank with the finger
// (tests/report/STUDY.md#guarded-press): what a press is like under guard and tank.
#include "tests/hw/simulated/press.hpp"

#include <gtest/gtest.h>

#include <string>

namespace haptic::hw::test {
namespace {

using core::RendererKind;

constexpr RendererKind kAll[] = {RendererKind::kStandard, RendererKind::kNullSpace,
                                 RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact};

/// Stops and stiffnesses of the table in tests/report/STUDY.md#chosen-presses-finger_sign_change,
/// and both joints at 6000 N/m.
struct Row {
  Eigen::Vector2d stop;
  double stiffness;
};
const Row kRows[] = {{{18.0, kNoStop}, 1500.0},
                     {{18.0, kNoStop}, 6000.0},
                     {{kNoStop, 25.0}, 1500.0},
                     {{18.0, 25.0}, 1500.0},
                     {{18.0, 25.0}, 6000.0}};

Press press_of(RendererKind renderer, const Row& row) {
  Press press;
  press.renderer = renderer;
  press.stop = row.stop;
  press.stiffness = row.stiffness;
  return press;
}

/// (35 + 15 cos, 35 + direction 15 sin) deg, four rounds of 1 s; -1 pumps.
Press rounds(RendererKind renderer, int direction) {
  Press press;
  press.renderer = renderer;
  press.seconds = 4.0;
  press.aim = [direction](double t) {
    const double phase = 2.0 * M_PI * t;
    return Eigen::Vector2d(35 + 15 * std::cos(phase), 35 + direction * 15 * std::sin(phase));
  };
  return press;
}

TEST(Press, UnguardedRenderersEndAsPredicted) {
  struct End {
    RendererKind renderer;
    int row;
    double mcp, pip, force;
  };
  // The table of tests/report/STUDY.md#chosen-presses-finger_sign_change, null-space and (8): the
  // rows without a runaway.
  const End ends[] = {{RendererKind::kNullSpace, 0, 47.7, 45.5, -4.0},
                      {RendererKind::kSubspaceLinear, 0, 47.4, 44.8, -4.6},
                      {RendererKind::kSubspaceExact, 0, 50.8, 51.7, +1.6},
                      {RendererKind::kSubspaceLinear, 1, 38.5, 29.2, -16.1},
                      {RendererKind::kSubspaceLinear, 2, 46.6, 43.3, -5.8},
                      {RendererKind::kSubspaceExact, 2, 46.7, 43.4, -5.8},
                      {RendererKind::kSubspaceLinear, 3, 44.4, 39.1, -9.1},
                      {RendererKind::kSubspaceExact, 3, 44.2, 38.7, -9.4}};
  for (const End& expected : ends) {
    SCOPED_TRACE(std::string(core::name(expected.renderer)) + " row " +
                 std::to_string(expected.row));
    const Pressed got = run(press_of(expected.renderer, kRows[expected.row]));
    // The baseline's stiffness depends on the region over which ||J_a|| is averaged.
    const bool baseline = expected.renderer == RendererKind::kNullSpace;
    EXPECT_NEAR(got.end[0], expected.mcp, baseline ? 0.6 : 0.1);
    EXPECT_NEAR(got.end[1], expected.pip, baseline ? 1.2 : 0.1);
    EXPECT_NEAR(got.end_force, expected.force, baseline ? 1.0 : 0.1);
  }
}

TEST(Press, TheGuardNeverPullsAway) {
  for (const RendererKind renderer : kAll) {
    for (const Row& row : kRows) {
      SCOPED_TRACE(std::string(core::name(renderer)) + " at " + std::to_string(row.stiffness));
      Press press = press_of(renderer, row);
      press.force = false;
      const Pressed free = run(press);
      press.force = press.direction_guard = true;
      press.passivity = tank_of(0.0);
      const Pressed guarded = run(press);
      EXPECT_GE(guarded.least_power, 0.0);
      EXPECT_LE(guarded.penetration, free.penetration + 0.5);
      EXPECT_LE(guarded.most_net, 1e-9);
    }
  }
}

TEST(Press, WithoutTheGuardItPullsAway) {
  EXPECT_LT(run(press_of(RendererKind::kSubspaceExact, kRows[1])).least_power, -0.01);
  EXPECT_LT(run(press_of(RendererKind::kStandard, kRows[1])).least_power, -1e-3);
}

TEST(Press, EmptyTankLeavesAPressAlone) {
  for (const RendererKind renderer :
       {RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
    for (const Row& row : kRows) {
      Press press = press_of(renderer, row);
      press.direction_guard = renderer == RendererKind::kSubspaceExact;
      const Pressed plain = run(press);
      press.passivity = tank_of(0.0);
      const Pressed tank = run(press);
      SCOPED_TRACE(std::string(core::name(renderer)) + " at " + std::to_string(row.stiffness));
      EXPECT_EQ(tank.throttled, 0);
      EXPECT_NEAR(tank.end_force, plain.end_force, 1e-6);
      EXPECT_NEAR(tank.peak_force, plain.peak_force, 1e-6);
    }
  }
}

TEST(Press, SlowPlanesMatchAFastClient) {
  for (const RendererKind renderer : kAll) {
    for (const Row& row : kRows) {
      SCOPED_TRACE(std::string(core::name(renderer)) + " at " + std::to_string(row.stiffness));
      Press press = press_of(renderer, row);
      press.direction_guard = true;
      press.passivity = tank_of(0.0);
      const Pressed held = run(press);
      press.planes = true;
      const Pressed planes = run(press);
      EXPECT_NEAR((planes.end - held.end).norm(), 0.0, 0.1);
      EXPECT_NEAR(planes.end_force, held.end_force, 0.05);
      EXPECT_GE(planes.least_power, 0.0);
      EXPECT_LE(planes.most_net, 1e-9);
    }
  }
}

TEST(Press, TheTankStopsPumping) {
  for (const RendererKind renderer : kAll) {
    for (const double initial : {0.0, 1e-3}) {
      for (const int direction : {+1, -1}) {
        SCOPED_TRACE(std::string(core::name(renderer)) + " " + std::to_string(direction));
        Press press = rounds(renderer, direction);
        press.direction_guard = true;
        press.passivity = tank_of(initial);
        EXPECT_LE(run(press).most_net, initial + 1e-9);
      }
    }
  }
}

TEST(Press, WithoutTheTankRoundsPump) {
  EXPECT_NEAR(run(rounds(RendererKind::kSubspaceLinear, -1)).work, 0.171, 0.025);
  EXPECT_LT(run(rounds(RendererKind::kSubspaceLinear, +1)).work, 0.0);
}

}  // namespace
}  // namespace haptic::hw::test
