#include "core/src/tick/supervisor.hpp"

#include <gtest/gtest.h>

#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using std::chrono::milliseconds;

/// A device with one actuated DoF that is well, under a lease, with planes at its probe.
class SupervisorTest : public testing::Test {
 protected:
  SupervisorTest() {
    settings.stiffness = settings.engage_window = one(1000.0);
    in.command.lease_held = true;
    in.command.tenure = 1;
    in.device.armed = true;
    sensed.q = one(0.0);
    sensed.ready = sensed.recent = true;
    proxy.mode = ProxyMode::kPlanes;
    proxy.tenure = 1;
    proxy.level = Staleness::kFresh;
    proxy.ladder = 1.0;
    proxy.gapless_samples = 1000;
    anchor.anchored = anchor.in_the_way = true;
    anchor.q_star = one(0.01);
  }
  Lifecycle step() {
    in.now += milliseconds(1);
    proxy.gapless_since = in.now - milliseconds(1000);
    return supervisor.step(in, beat, settings, sensed, proxy, anchor, output);
  }
  Lifecycle run(int ticks) {
    Lifecycle life;
    for (int i = 0; i < ticks; ++i) life = step();
    return life;
  }
  /// ENGAGED with g = 1, in 200 ticks.
  Lifecycle engage() {
    run(3);
    ++in.command.engage_id;
    EXPECT_TRUE(step().engaged);
    return run(200);
  }
  Lifecycle clear(FaultSet faults) {
    in.command.clear = faults;
    ++in.command.clear_id;
    return step();
  }
  static FaultSet only(Fault fault) {
    FaultSet set;
    set.set(fault);
    return set;
  }

  Supervisor supervisor{DofLayout{true}, milliseconds(1)};
  TickInput in{.now = TimePoint(milliseconds(1000))};
  Beat beat{.tick = 1, .dt = milliseconds(1)};
  Settings settings{};
  Sensed sensed{};
  ProxyInUse proxy{};
  Anchor anchor{};
  FaultSet output{};
};

TEST_F(SupervisorTest, EngageRampsGainIn200Ms) {
  run(3);
  ++in.command.engage_id;
  const Lifecycle first = step();
  EXPECT_EQ(first.state, LifecycleState::kEngaging);
  EXPECT_TRUE(first.engaged && first.arm);
  EXPECT_DOUBLE_EQ(first.gain, 1.0 / 200.0);
  EXPECT_FALSE(step().engaged) << "of its tick only";
  EXPECT_LT(run(197).gain, 1.0);
  const Lifecycle last = run(2);
  EXPECT_EQ(last.gain, 1.0);
  EXPECT_EQ(last.damping_gain, 1.0);
  EXPECT_EQ(last.state, LifecycleState::kEngaged);
}

TEST_F(SupervisorTest, ReleaseInTheSameTickWins) {
  run(3);
  ++in.command.engage_id;
  ++in.command.release_id;
  const Lifecycle life = step();
  EXPECT_EQ(life.engage.verdict, EngageVerdict::kReleased);
  EXPECT_EQ(life.state, LifecycleState::kArmed);
}

TEST_F(SupervisorTest, EachRequestActsOnce) {
  engage();
  ++in.command.release_id;
  EXPECT_EQ(step().state, LifecycleState::kReleasing);
  EXPECT_EQ(run(100).state, LifecycleState::kArmed);
  EXPECT_EQ(run(300).gain, 0.0) << "the Engage before is used up";
}

TEST_F(SupervisorTest, AnyFaultLatchesAndEndsForce) {
  struct Source {
    FaultSet* set;
    Fault fault;
  };
  for (const Source& source :
       {Source{&beat.faults, Fault::kLoopLate}, Source{&sensed.faults, Fault::kSampleNotFinite},
        Source{&output, Fault::kOutputNotFinite}}) {
    engage();
    source.set->set(source.fault);
    Lifecycle life = step();
    EXPECT_EQ(life.state, LifecycleState::kFault);
    EXPECT_EQ(life.gain, 0.0);
    EXPECT_FALSE(life.arm);
    *source.set = {};
    EXPECT_TRUE(run(5).faults.has(source.fault)) << "latched";
    life = clear(only(source.fault));
    EXPECT_FALSE(life.clear.refused.any());
    EXPECT_EQ(life.state, LifecycleState::kIdle);
  }
}

TEST_F(SupervisorTest, PresentCauseIsNotCleared) {
  sensed.faults.set(Fault::kDeviceSilent);
  step();
  const Lifecycle life = clear(only(Fault::kDeviceSilent));
  EXPECT_EQ(life.clear.refused, only(Fault::kDeviceSilent));
  EXPECT_EQ(life.state, LifecycleState::kFault);
}

TEST_F(SupervisorTest, OnlyNamedFaultsAreCleared) {
  beat.faults.set(Fault::kLoopLate);
  sensed.faults.set(Fault::kDeviceLost);
  step();
  beat.faults = sensed.faults = {};
  EXPECT_EQ(clear(only(Fault::kLoopLate)).faults, only(Fault::kDeviceLost));
}

TEST_F(SupervisorTest, UnseenStopIsNotCleared) {
  ++in.command.stop_id;
  step();
  in.command.clear_stop_id = in.command.stop_id;
  ++in.command.stop_id;  // another person's, which the clearing one has not seen
  Lifecycle life = clear(only(Fault::kEmergencyStop));
  EXPECT_TRUE(life.clear.refused.has(Fault::kEmergencyStop));
  EXPECT_EQ(life.state, LifecycleState::kFault);
  in.command.clear_stop_id = in.command.stop_id;
  life = clear(only(Fault::kEmergencyStop));
  EXPECT_FALSE(life.clear.refused.any());
  EXPECT_EQ(life.state, LifecycleState::kIdle);
}

/// The stop acted in a tick before the clear came.
TEST_F(SupervisorTest, EarlierUnseenStopIsNotCleared) {
  ++in.command.stop_id;
  step();
  in.command.clear_stop_id = in.command.stop_id;
  ++in.command.stop_id;
  step();
  EXPECT_TRUE(clear(only(Fault::kEmergencyStop)).clear.refused.has(Fault::kEmergencyStop));
}

TEST_F(SupervisorTest, OnlyAStopLatchesBeforeReady) {
  sensed.ready = false;
  sensed.faults.set(Fault::kDeviceLost);
  EXPECT_FALSE(step().faults.any());
  ++in.command.stop_id;
  EXPECT_TRUE(step().faults.has(Fault::kEmergencyStop));
}

TEST_F(SupervisorTest, LadderBoundsGainAndRecoveryRamps) {
  engage();
  proxy.ladder = 0.5;
  EXPECT_NEAR(run(40).gain, 0.5, 1e-12) << "1/80 per ms";
  proxy.ladder = 1.0;
  EXPECT_NEAR(step().gain, 0.5 + 1.0 / 200.0, 1e-12);
}

TEST_F(SupervisorTest, LostProxyGivesForceUpOnce) {
  engage();
  proxy.level = Staleness::kLost;
  proxy.ladder = 0.0;
  int lost = 0;
  Lifecycle life;
  for (int i = 0; i < 200; ++i) lost += (life = step()).lost ? 1 : 0;
  EXPECT_EQ(lost, 1);
  EXPECT_EQ(life.state, LifecycleState::kArmed);
  EXPECT_EQ(life.gain, 0.0);
  EXPECT_EQ(life.damping_gain, 1.0) << "the client was granted it";
  proxy.level = Staleness::kFresh;
  proxy.ladder = 1.0;
  EXPECT_EQ(run(300).gain, 0.0) << "no force without a new Engage";
}

TEST_F(SupervisorTest, LostTrackerGivesForceUpToo) {
  engage();
  sensed.tracker.on = true;
  sensed.tracker.level = Staleness::kLost;
  EXPECT_TRUE(step().lost);
}

TEST_F(SupervisorTest, NextLeaseInheritsNoDamping) {
  engage();
  proxy.level = Staleness::kLost;
  EXPECT_EQ(run(100).damping_gain, 1.0);
  ++in.command.tenure;
  EXPECT_EQ(step().damping_gain, 0.0);
}

TEST_F(SupervisorTest, LeaseEndFadesThenDisarms) {
  engage();
  in.command.lease_held = false;
  Lifecycle life = step();
  EXPECT_EQ(life.state, LifecycleState::kReleasing);
  EXPECT_NEAR(life.gain, 1.0 - 1.0 / 80.0, 1e-12);
  life = run(81);
  EXPECT_EQ(life.state, LifecycleState::kIdle);
  EXPECT_EQ(life.gain, 0.0);
  EXPECT_FALSE(life.arm);
}

TEST_F(SupervisorTest, EachLeaseNeedsAFreeProbe) {
  proxy.mode = ProxyMode::kHeld;
  const auto ask = [&] {
    ++in.command.engage_id;
    return step().engage.verdict;
  };
  EXPECT_TRUE(run(3).limiters.has(Limiter::kNeverFree));
  EXPECT_EQ(ask(), EngageVerdict::kNeverFree);
  anchor.in_the_way = false;
  proxy.mode = ProxyMode::kFree;
  proxy.tenure = 0;
  step();  // of the lease before: under force it stays in use
  proxy.mode = ProxyMode::kHeld;
  anchor.in_the_way = true;
  proxy.tenure = 1;
  EXPECT_EQ(ask(), EngageVerdict::kNeverFree);
  anchor.in_the_way = false;
  EXPECT_EQ(ask(), EngageVerdict::kNeverFree) << "a held proxy that echoes the probe";
  proxy.mode = ProxyMode::kFree;
  step();
  proxy.mode = ProxyMode::kHeld;
  anchor.in_the_way = true;
  EXPECT_FALSE(run(300).limiters.any()) << "once is enough";
  EXPECT_EQ(ask(), EngageVerdict::kAccepted);
  proxy.level = Staleness::kLost;
  EXPECT_EQ(step().state, LifecycleState::kArmed);
  proxy.level = Staleness::kFresh;
  EXPECT_EQ(ask(), EngageVerdict::kAccepted) << "force comes back inside the object";
  proxy.tenure = ++in.command.tenure;
  EXPECT_EQ(run(300).state, LifecycleState::kArmed);
  EXPECT_EQ(ask(), EngageVerdict::kNeverFree) << "the next lease does not inherit it";
}

TEST_F(SupervisorTest, SaysWhatForceWaitsFor) {
  proxy.mode = ProxyMode::kFree;
  run(3);
  anchor.anchored = true;
  anchor.q_star = one(2.0);
  EXPECT_FALSE(step().limiters.any());
  ++in.command.engage_id;
  EXPECT_TRUE(step().limiters.has(Limiter::kOutsideWindow));
  EXPECT_TRUE(run(50).limiters.has(Limiter::kOutsideWindow));
  ++in.command.release_id;
  EXPECT_FALSE(step().limiters.any());
  proxy.too_fast = {500.0, 60.0};
  EXPECT_FALSE(step().limiters.any()) << "fresh all the same";
  proxy.level = Staleness::kFade;
  EXPECT_TRUE(step().limiters.has(Limiter::kTooFast));
}

TEST_F(SupervisorTest, DampingNeedsObstacleAndRecentRate) {
  engage();
  anchor.in_the_way = false;
  EXPECT_NEAR(step().damping_gain, 1.0 - 1.0 / 80.0, 1e-12);
  anchor.in_the_way = true;
  EXPECT_EQ(run(10).damping_gain, 1.0);
  sensed.recent = false;
  EXPECT_LT(step().damping_gain, 1.0);
}

TEST_F(SupervisorTest, RecordingsGapRampsOutAndIn) {
  engage();
  sensed.silent = true;
  Lifecycle life = run(90);
  EXPECT_EQ(life.gain, 0.0);
  EXPECT_EQ(life.state, LifecycleState::kEngaged);
  sensed.silent = false;
  EXPECT_NEAR(step().gain, 1.0 / 200.0, 1e-12);
}

}  // namespace
}  // namespace haptic::core
