// proto/README.md#states-of-a-device as a table, on injected time.
#include "haptic/core/safety/lifecycle.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "haptic/core/safety/limits.hpp"
#include "haptic/core/safety/staleness.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using std::chrono::milliseconds;
using S = LifecycleState;

StateEvents held() {
  return {.lease_held = true, .armed = true, .ready = true};
}
StateEvents with(bool StateEvents::*flag, bool value = true) {
  StateEvents e = held();
  e.*flag = value;
  return e;
}

/// A machine walked into `state` by events alone.
LifecycleMachine machine_in(LifecycleState state) {
  LifecycleMachine m;
  if (state == S::kInit) return m;
  if (state == S::kClosing) {
    m.step(with(&StateEvents::closing), 0.0);
    return m;
  }
  m.step({.ready = true}, 0.0);
  if (state == S::kIdle) return m;
  if (state == S::kFault) {
    m.step({.fault = true, .ready = true}, 0.0);
    return m;
  }
  m.step(held(), 0.0);
  if (state == S::kArmed) return m;
  m.step(with(&StateEvents::engage), 0.0);
  if (state == S::kEngaging) return m;
  m.step(held(), 1.0);
  if (state == S::kEngaged) return m;
  m.step(with(&StateEvents::release), 1.0);
  return m;
}

struct Transition {
  const char* what{};
  LifecycleState from{};
  StateEvents events{};
  double g{};
  LifecycleState to{};
};

TEST(LifecycleMachine, FollowsTheTableOfStates) {
  StateEvents nothing_held = {.ready = true};
  const Transition kTable[] = {
      {"device opens", S::kInit, {.ready = true}, 0, S::kIdle},
      {"not yet ready", S::kInit, {}, 0, S::kInit},
      {"no fault leaves INIT", S::kInit, {.fault = true}, 0, S::kInit},
      {"SIGTERM in INIT", S::kInit, {.closing = true}, 0, S::kClosing},
      {"lease and armed", S::kIdle, held(), 0, S::kArmed},
      {"lease, not armed yet", S::kIdle, {.lease_held = true, .ready = true}, 0, S::kIdle},
      {"SIGTERM in IDLE", S::kIdle, with(&StateEvents::closing), 0, S::kClosing},
      {"Engage", S::kArmed, with(&StateEvents::engage), 0, S::kEngaging},
      {"lease over", S::kArmed, nothing_held, 0, S::kIdle},
      {"preempted in ARMED", S::kArmed, with(&StateEvents::lease_changed), 0, S::kArmed},
      {"SIGTERM in ARMED", S::kArmed, with(&StateEvents::closing), 0, S::kClosing},
      {"g below 1", S::kEngaging, held(), 0.999, S::kEngaging},
      {"g reaches 1", S::kEngaging, held(), 1.0, S::kEngaged},
      {"lost while engaging", S::kEngaging, with(&StateEvents::lost), 0.3, S::kArmed},
      {"lost", S::kEngaged, with(&StateEvents::lost), 0.0, S::kArmed},
      {"Release while engaging", S::kEngaging, with(&StateEvents::release), 0.3, S::kReleasing},
      {"Release", S::kEngaged, with(&StateEvents::release), 1, S::kReleasing},
      {"preempted", S::kEngaged, with(&StateEvents::lease_changed), 1, S::kReleasing},
      {"stream ends", S::kEngaged, nothing_held, 1, S::kReleasing},
      {"SIGTERM under force", S::kEngaged, with(&StateEvents::closing), 1, S::kReleasing},
      {"still fading", S::kReleasing, held(), 0.01, S::kReleasing},
      {"faded, lease kept", S::kReleasing, held(), 0, S::kArmed},
      {"faded, lease gone", S::kReleasing, nothing_held, 0, S::kIdle},
      {"faded, SIGTERM", S::kReleasing, with(&StateEvents::closing), 0, S::kClosing},
      {"fault in IDLE", S::kIdle, with(&StateEvents::fault), 0, S::kFault},
      {"fault in ARMED", S::kArmed, with(&StateEvents::fault), 0, S::kFault},
      {"fault in ENGAGING", S::kEngaging, with(&StateEvents::fault), 0.5, S::kFault},
      {"fault in ENGAGED", S::kEngaged, with(&StateEvents::fault), 1, S::kFault},
      {"fault in RELEASING", S::kReleasing, with(&StateEvents::fault), 0.5, S::kFault},
      {"fault persists", S::kFault, with(&StateEvents::fault), 0, S::kFault},
      {"fault cleared", S::kFault, held(), 0, S::kIdle},
      {"SIGTERM in FAULT", S::kFault, {.fault = true, .closing = true}, 0, S::kClosing},
      {"CLOSING is the end", S::kClosing, held(), 0, S::kClosing},
  };
  for (const Transition& t : kTable) {
    LifecycleMachine m = machine_in(t.from);
    ASSERT_EQ(m.state(), t.from) << t.what;
    EXPECT_EQ(m.step(t.events, t.g), t.to) << t.what << ": got " << name(m.state());
  }
}

TEST(LifecycleMachine, ArmsOnlyUnderALease) {
  EXPECT_FALSE(machine_in(S::kInit).wants_armed());
  EXPECT_FALSE(machine_in(S::kIdle).wants_armed());
  EXPECT_TRUE(machine_in(S::kArmed).wants_armed());
  EXPECT_TRUE(machine_in(S::kReleasing).wants_armed());
  EXPECT_FALSE(machine_in(S::kFault).wants_armed());
  EXPECT_FALSE(machine_in(S::kClosing).wants_armed());
}

TEST(Staleness, IntervalsAreHalfOpen) {
  const StalenessLimits limits{milliseconds(20), milliseconds(100), milliseconds(180)};
  const Duration ns(1);
  const auto level = [&](Duration age) { return staleness(age, Duration::zero(), limits); };
  EXPECT_EQ(level(milliseconds(20) - ns), Staleness::kFresh);
  EXPECT_EQ(level(milliseconds(20)), Staleness::kHold);
  EXPECT_EQ(level(milliseconds(100) - ns), Staleness::kHold);
  EXPECT_EQ(level(milliseconds(100)), Staleness::kFade);
  EXPECT_EQ(level(milliseconds(180) - ns), Staleness::kFade);
  EXPECT_EQ(level(milliseconds(180)), Staleness::kLost);
  EXPECT_EQ(ladder(milliseconds(100), limits), 1.0);
  EXPECT_NEAR(ladder(milliseconds(140), limits), 0.5, 1e-12);
  EXPECT_EQ(ladder(milliseconds(180), limits), 0.0);
}

TEST(Staleness, SampleMayOnlyShortenItsFreshness) {
  const StalenessLimits limits{milliseconds(20), milliseconds(100), milliseconds(180)};
  EXPECT_EQ(staleness(milliseconds(6), milliseconds(5), limits), Staleness::kHold);
  EXPECT_EQ(staleness(milliseconds(21), milliseconds(90), limits), Staleness::kHold);
}

TEST(Staleness, DefaultFreshnessIsBoundedPeriods) {
  EXPECT_EQ(default_fresh_end(100.0), milliseconds(25));
  EXPECT_EQ(default_fresh_end(1000.0), milliseconds(5));
  EXPECT_EQ(default_fresh_end(10.0), milliseconds(80));
}

TEST(Staleness, NamesInconsistentLimits) {
  EXPECT_EQ(check({milliseconds(20), milliseconds(100), milliseconds(150)}), nullptr);
  EXPECT_NE(check({milliseconds(0), milliseconds(100), milliseconds(180)}), nullptr);
  EXPECT_NE(check({milliseconds(101), milliseconds(100), milliseconds(180)}), nullptr);
  EXPECT_NE(check({milliseconds(20), milliseconds(100), milliseconds(149)}), nullptr);
}

struct ForceLimiterRules : ::testing::Test {
  ForceLimiter limiter;
  LimiterSet active;
  double step(double elastic, double damping, double gain) {
    active = {};
    return limiter.step(elastic, damping, gain, 10.0, 1000.0, milliseconds(1), active).total;
  }
};

TEST_F(ForceLimiterRules, SlewsAndSaturates) {
  EXPECT_DOUBLE_EQ(step(50.0, 0.0, 1.0), 1.0);
  EXPECT_TRUE(active.has(Limiter::kSlew));
  EXPECT_TRUE(active.has(Limiter::kSaturation));
  for (int i = 0; i < 20; ++i) step(50.0, 0.0, 1.0);
  EXPECT_DOUBLE_EQ(step(50.0, 0.0, 1.0), 10.0);
  EXPECT_FALSE(active.has(Limiter::kSlew));
}

TEST_F(ForceLimiterRules, DampingStaysWithinTheForceLimit) {
  for (int i = 0; i < 20; ++i) EXPECT_LE(std::abs(step(0.0, -50.0, 0.0)), 10.0);
  EXPECT_DOUBLE_EQ(step(0.0, -50.0, 0.0), -10.0);
  EXPECT_TRUE(active.has(Limiter::kSaturation));
}

TEST_F(ForceLimiterRules, EnvelopeOverridesTheSlewLimit) {
  for (int i = 0; i < 20; ++i) step(10.0, -2.0, 1.0);
  LimiterSet set;
  const LimitedForce at_zero = limiter.step(0.0, -2.0, 0.0, 10.0, 1000.0, milliseconds(1), set);
  EXPECT_EQ(at_zero.total, at_zero.damping) << "elastic part exactly 0 at gain 0";
  EXPECT_TRUE(set.has(Limiter::kEnvelope));
}

TEST_F(ForceLimiterRules, EnvelopeNeverMakesForceGrow) {
  for (int i = 0; i < 20; ++i) step(10.0, 0.0, 1.0);
  const double before = step(10.0, 0.0, 1.0);
  EXPECT_LE(step(10.0, 0.0, 0.5), before);
  EXPECT_DOUBLE_EQ(step(10.0, 0.0, 0.5), 5.0);
}

TEST(Within, RefusesNaN) {
  const VecQ lower = two(-1.0, -1.0), upper = two(1.0, 1.0);
  EXPECT_TRUE(within(two(1.0, -1.0), lower, upper));
  EXPECT_FALSE(within(two(0.0, std::nan("")), lower, upper));
}

}  // namespace
}  // namespace haptic::core
