// The energy tank inside the tick (core/METHOD.md#energy-tank; tests/report/STUDY.md#proxy-step).
#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/tick/finger_bench.hpp"

namespace haptic::core {
namespace {

using namespace test;

double saturated_potential(double d) {
  const double corner = kForceLimit / kStiffness;
  return std::abs(d) <= corner
             ? 0.5 * kStiffness * d * d
             : 0.5 * kStiffness * corner * corner + kForceLimit * (std::abs(d) - corner);
}

TEST(TankInTheTick, CapsEveryRenderersProxyStep) {
  constexpr double kInitial = 0.003;
  for (const RendererKind renderer : kEveryRenderer) {
    SCOPED_TRACE(name(renderer));
    Bench bench(with_tank(renderer, kInitial));
    bench.engage();
    bench.target = joints(1.1, 1.3);  // from (0.5, 0.5)
    const TickRecord record = bench.tick();
    EXPECT_TRUE(record.effort.passivity.throttled);
    EXPECT_NEAR(record.effort.passivity.storage, kInitial, 1e-12);
    EXPECT_EQ(record.effort.passivity.tank, 0.0);
    EXPECT_NEAR(std::abs(record.effort.tau_a[0]), std::sqrt(2.0 * kStiffness * kInitial), 1e-9);
    EXPECT_NEAR(record.effort.q_star[0] - record.sensed.q[0], record.effort.tau_a[0] / kStiffness,
                1e-12);
  }
}

TEST(TankInTheTick, KeepsTheTargetUntilAffordable) {
  PipelineConfig config = with_tank(RendererKind::kSubspaceExact, 0.003);
  config.passivity.device_damping = VecA::Constant(1, 1e3);  // pays the hold over the jumps below
  Bench bench(config);
  bench.engage();
  bench.target = joints(0.9, 0.6);
  EXPECT_TRUE(bench.tick().effort.passivity.throttled);
  // The user goes to the proxy: the wanted anchor then costs nothing, and is in use again.
  bench.put(bench.target);
  EXPECT_FALSE(bench.tick().effort.passivity.throttled);
  bench.put(joints(0.88, 0.6));
  TickRecord record;
  for (int i = 0; i < 3; ++i) record = bench.tick();
  VecQ q_star = record.sensed.q;
  ASSERT_EQ(bench.pipeline.config().kinematics->inverse(bench.target, q_star),
            InverseStatus::kExact);
  EXPECT_NEAR(record.effort.q_star[0], q_star[0], 1e-12);
}

TEST(TankInTheTick, DebitsTheRampOfTheGain) {
  Bench bench(with_tank(RendererKind::kSubspaceExact, 0.02));
  bench.target = joints(0.45, 0.45);
  const TickRecord record = bench.engage();
  const double d = record.effort.q_star[0] - record.sensed.q[0];
  EXPECT_FALSE(record.effort.passivity.throttled);
  EXPECT_NEAR(record.effort.passivity.tank, 0.02 - saturated_potential(d), 1e-12);

  Bench strict(with_tank(RendererKind::kSubspaceExact, 0.0));
  strict.target = joints(0.45, 0.45);
  EXPECT_EQ(strict.engage().effort.tau_a[0], 0.0) << "nothing to pay the ramp with: no force";
}

TEST(TankInTheTick, DebitsARiseOfStiffness) {
  Bench bench(with_tank(RendererKind::kSubspaceExact, 0.02));
  bench.input.settings.id = 1;
  bench.input.settings.stiffness = VecA::Constant(1, 500.0);
  bench.target = joints(0.45, 0.45);
  const TickRecord before = bench.engage();
  bench.input.settings.id = 2;
  bench.input.settings.stiffness = VecA::Constant(1, 1500.0);
  const TickRecord after = bench.tick();
  EXPECT_GT(after.effort.passivity.storage, 2.9 * before.effort.passivity.storage);
  EXPECT_NEAR(after.effort.passivity.tank,
              before.effort.passivity.tank - 2.0 * before.effort.passivity.storage, 1e-12);
}

TEST(TankInTheTick, AbsentItChangesNoBit) {
  for (const RendererKind renderer : kEveryRenderer) {
    Bench plain(config_of(renderer));
    PipelineConfig open = with_tank(renderer, 1e6);
    open.passivity.tank.capacity = 1e6;
    Bench full(open);
    plain.target = full.target = joints(0.45, 0.4);
    plain.engage();
    full.engage();
    for (int i = 0; i < 200; ++i) {
      const VecX x = joints(0.5 + 1e-3 * i, 0.5 - 5e-4 * i);
      plain.put(x);
      full.put(x);
      const TickRecord a = plain.tick(), b = full.tick();
      ASSERT_EQ(a.effort.tau_a[0], b.effort.tau_a[0])
          << "a tank that can pay everything changes nothing";
      ASSERT_EQ(a.effort.passivity.storage, 0.0);
      ASSERT_GT(b.effort.passivity.storage, 0.0);
    }
  }
}

}  // namespace
}  // namespace haptic::core
