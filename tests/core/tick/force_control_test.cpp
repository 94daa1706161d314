// Force control by the server in the pipeline, and the book of energy over the measured force.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "finger_bench.hpp"

namespace haptic::core::test {
namespace {

PipelineConfig with_loop() {
  PipelineConfig c = config_of(RendererKind::kSubspaceExact);
  c.scene.stiffness = VecA::Constant(1, 400.0);
  c.force_control.loops = {ForceLoopGains{1.5, 60.0, 0.0, 0.2, 25.0}};
  return c;
}

/// A drive behind Coulomb friction and a lag, pushing on something that does not move.
class StickyDrive {
 public:
  double measured() const { return force_; }
  void give(double u) {
    const double friction = 3.0;
    const double through = u > friction ? u - friction : (u < -friction ? u + friction : 0.0);
    force_ += 0.1 * (through - force_);  // 10 ms
  }

 private:
  double force_{0.0};
};

TEST(ForceControlInTheTick, MeasuredForceReachesTheCommand) {
  Bench bench(with_loop());
  StickyDrive drive;
  const auto step = [&] {
    bench.input.device.sample.tau_measured = VecA::Constant(1, drive.measured());
    const TickRecord record = bench.tick();
    drive.give(record.effort.drive[0]);
    return record;
  };
  bench.input.device.sample.tau_measured = VecA::Zero(1);
  bench.engage();
  bench.put(joints(0.65, 0.65));
  TickRecord record;
  for (int i = 0; i < 1500; ++i) record = step();
  ASSERT_GT(std::abs(record.effort.tau_a[0]), 1.0);
  EXPECT_NEAR(drive.measured(), record.effort.tau_a[0], 1e-3 * std::abs(record.effort.tau_a[0]));
  EXPECT_NEAR(std::abs(record.effort.drive[0]), std::abs(record.effort.tau_a[0]) + 3.0, 0.05)
      << "the drive gives the friction on top";
}

TEST(ForceControlInTheTick, FaultRemovesForceWithinATick) {
  Bench bench(with_loop());
  bench.input.device.sample.tau_measured = VecA::Zero(1);
  bench.engage();
  bench.put(joints(0.65, 0.65));
  TickRecord record;
  for (int i = 0; i < 2000; ++i) record = bench.tick();  // measured stays 0: the integral winds up
  EXPECT_GT(std::abs(record.effort.drive[0]), 10.0);
  EXPECT_TRUE(record.limiters().has(Limiter::kDriveLimit));
  ++bench.input.command.stop_id;
  record = bench.tick();
  EXPECT_EQ(record.effort.drive[0], 0.0);
}

/// A finger bent against a proxy, with a force limit of 15 N, and 10 N more for the drive.
class PressedLoop : public Bench {
 public:
  explicit PressedLoop(double slew, std::vector<CellRatings> cells = {})
      : Bench(limited(slew, std::move(cells))) {
    input.device.sample.tau_measured = VecA::Zero(1);
    engage();
    put(joints(0.65, 0.65));
  }

 private:
  static PipelineConfig limited(double slew, std::vector<CellRatings> cells) {
    PipelineConfig config = with_loop();
    config.scene.force_limit = VecA::Constant(1, 15.0);
    config.scene.slew_limit = VecA::Constant(1, slew);
    config.force_control.cells = std::move(cells);
    return config;
  }
};

TEST(ForceControlInTheTick, TheForceLimitBoundsTheDrive) {
  PressedLoop bench(1e5);
  bench.run(2000);  // measured stays 0
  EXPECT_NEAR(std::abs(bench.record.effort.drive[0]), 25.0, 0.5);
  EXPECT_LE(std::abs(bench.record.effort.drive[0]), 25.0);
  bench.input.settings.id = 1;
  bench.input.settings.force_limit = VecA::Constant(1, 4.0);
  bench.run(10);
  EXPECT_NEAR(std::abs(bench.record.effort.drive[0]), 14.0, 0.5);
  EXPECT_LE(std::abs(bench.record.effort.drive[0]), 14.0);
}

TEST(ForceControlInTheTick, SilenceEndsAnySlewedDrive) {
  PressedLoop bench(1e5);
  StickyDrive drive;
  const auto step = [&](bool publish) {
    bench.input.device.sample.tau_measured[0] = drive.measured();
    drive.give(bench.tick(true, publish).effort.drive[0]);
  };
  for (int i = 0; i < 1500; ++i) step(true);
  ASSERT_GT(std::abs(drive.measured()), 1.0);
  bench.input.settings.id = 1;
  bench.input.settings.slew_limit = VecA::Constant(1, 5e-324);
  for (int i = 0; i < 100; ++i) step(true);
  EXPECT_GT(std::abs(drive.measured()), 1.0) << "it holds what it has";
  for (int i = 0; i < 400; ++i) step(false);
  EXPECT_EQ(bench.record.life.gain, 0.0);
  EXPECT_NEAR(drive.measured(), 0.0, 0.1);
}

TEST(ForceControlInTheTick, ALyingCellZeroesItsTick) {
  PressedLoop bench(1e5, {{.range = 50.0}});
  bench.run(100);
  ASSERT_NE(bench.record.effort.drive[0], 0.0);
  bench.input.device.sample.tau_measured[0] = -60.0;
  bench.tick();
  EXPECT_EQ(bench.record.life.state, LifecycleState::kFault);
  EXPECT_TRUE(bench.record.faults().has(Fault::kForceOutOfRange));
  EXPECT_EQ(bench.record.effort.drive[0], 0.0);
  const auto clear = [&] {
    ++bench.input.command.clear_id;
    bench.input.command.clear.set(Fault::kForceOutOfRange);
    return bench.tick().life.clear.refused.any();
  };
  EXPECT_TRUE(clear()) << "its cause persists";
  bench.input.device.sample.tau_measured[0] = 0.0;
  EXPECT_FALSE(clear());
  EXPECT_EQ(bench.record.life.state, LifecycleState::kIdle);
}

/// Measured stays 0.
TEST(ForceControlInTheTick, APressFindsADeadCell) {
  const struct {
    CellRatings ratings;
    Fault fault;
    int ticks;
  } cases[] = {{{.swing = 2.0}, Fault::kForceStuck, CellWatch::kSame + 5},
               {{.friction = 8.0, .damping = 0.0}, Fault::kForceDisagrees, 300}};
  for (const auto& c : cases) {
    PressedLoop bench(1e5, {c.ratings});
    int ticks = 0;
    while (ticks < 1000 && !bench.tick().faults().any()) ++ticks;
    EXPECT_TRUE(bench.record.faults().has(c.fault)) << reason(c.fault);
    EXPECT_LE(ticks, c.ticks) << reason(c.fault);
  }
}

TEST(ForceControlInTheTick, EnergyBookTakesTheForceHeld) {
  PipelineConfig config = with_tank(RendererKind::kSubspaceExact, 0.05);
  config.passivity.observer.enabled = true;
  config.passivity.observer.inertia = VecA::Constant(1, 1.0);
  Bench bench(config);
  bench.input.device.sample.tau_measured = VecA::Zero(1);
  TickRecord before = bench.engage();
  double before_force = 0.0;
  for (int i = 1; i <= 200; ++i) {
    const double bend = 0.15 * std::sin(M_PI * i / 200.0);
    bench.put(joints(0.5 + bend, 0.5 + bend));
    // Nothing of what is commanded arrives: the board measures a force of its own.
    const double force = 0.3 * std::sin(0.1 * i);
    bench.input.device.sample.tau_measured = VecA::Constant(1, force);
    const TickRecord record = bench.tick();
    const PassivityRecord& book = record.effort.passivity;
    // Conservation: of what the measured force took from the user, what the spring did not store.
    const double stored = (book.storage - book.injected) - before.effort.passivity.storage;
    const double work = 0.5 * (force + before_force) * (record.sensed.q[0] - before.sensed.q[0]);
    EXPECT_NEAR(book.hold.limits + book.hold.rendered - book.hold.leak, -work - stored, 1e-12) << i;
    before = record;
    before_force = force;
  }
}

}  // namespace
}  // namespace haptic::core::test
