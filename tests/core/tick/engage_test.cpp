#include "core/src/tick/engage.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using std::chrono::milliseconds;

/// Everything as an Engage needs it; each test spoils one thing.
class EngageTest : public testing::Test {
 protected:
  EngageTest() {
    settings.stiffness = two(1000.0, 500.0);
    settings.engage_window = two(5.0, 5.0);
    sensed.q = two(0.1, 0.2);
    sensed.ready = sensed.recent = true;
    anchor.anchored = true;
    anchor.q_star = two(0.104, 0.2);
    proxy.mode = ProxyMode::kHeld;
    proxy.gapless_samples = 10;
    proxy.gapless_since = now - milliseconds(200);
  }
  [[nodiscard]] EngageAnswer judge() const {
    return judge_engage(3, {now, state, faulted, sensed, proxy, anchor, settings, layout,
                            milliseconds(2), was_free});
  }
  void expect_refused(EngageVerdict verdict, double value, double limit, int index = 0) const {
    const EngageAnswer answer = judge();
    EXPECT_EQ(answer.id, 3u);
    EXPECT_EQ(answer.verdict, verdict);
    EXPECT_EQ(answer.value, value);
    EXPECT_EQ(answer.limit, limit);
    EXPECT_EQ(answer.index, index);
  }
  const DofLayout layout{true, true};
  TimePoint now{milliseconds(5000)};
  LifecycleState state{LifecycleState::kArmed};
  bool faulted{false};
  bool was_free{true};
  Settings settings{};
  Sensed sensed{};
  ProxyInUse proxy{};
  Anchor anchor{};
};

TEST_F(EngageTest, AcceptsAGoodStreamWhileArmed) {
  EXPECT_EQ(judge().verdict, EngageVerdict::kAccepted);
}

TEST_F(EngageTest, OtherStatesAreRefused) {
  state = LifecycleState::kIdle;
  expect_refused(EngageVerdict::kNotArmed, 2.0, 3.0);
  state = LifecycleState::kArmed;
  faulted = true;
  expect_refused(EngageVerdict::kNotArmed, 3.0, 3.0);
}

TEST_F(EngageTest, EngagedAlreadyIsAccepted) {
  proxy = {};
  for (const LifecycleState engaged : {LifecycleState::kEngaging, LifecycleState::kEngaged}) {
    state = engaged;
    EXPECT_EQ(judge().verdict, EngageVerdict::kAccepted);
  }
}

TEST_F(EngageTest, StaleStreamIsRefused) {
  proxy.age = milliseconds(100);
  expect_refused(EngageVerdict::kStreamStale, 100.0, 100.0);
  proxy = {};
  expect_refused(EngageVerdict::kStreamStale, HUGE_VAL, 100.0);
}

TEST_F(EngageTest, YoungStreamIsRefused) {
  proxy.gapless_samples = 9;
  expect_refused(EngageVerdict::kTooFewSamples, 9.0, 10.0);
  proxy.gapless_samples = 10;
  proxy.gapless_since = now - milliseconds(199);
  expect_refused(EngageVerdict::kStreamTooYoung, 199.0, 200.0);
}

TEST_F(EngageTest, TooManySamplesAreNamed) {
  proxy.too_fast = {500.0, 60.0};
  EXPECT_EQ(judge().verdict, EngageVerdict::kAccepted) << "they are fresh enough";
  proxy.age = milliseconds(180);
  expect_refused(EngageVerdict::kTooFast, 500.0, 60.0);
  proxy.age = {};
  proxy.gapless_samples = 3;
  expect_refused(EngageVerdict::kTooFast, 500.0, 60.0);
}

TEST_F(EngageTest, SilentDeviceIsRefused) {
  sensed.recent = false;
  sensed.age = milliseconds(7);
  expect_refused(EngageVerdict::kDeviceStale, 7.0, 6.0);
}

TEST_F(EngageTest, StaleTrackerIsRefused) {
  sensed.tracker = {.on = true, .seq = 4, .age = milliseconds(60), .hold_end = milliseconds(60)};
  expect_refused(EngageVerdict::kTrackerStale, 60.0, 60.0);
  sensed.tracker.seq = 0;
  expect_refused(EngageVerdict::kTrackerStale, HUGE_VAL, 60.0);
}

TEST_F(EngageTest, RefusesAForceJumpPerDof) {
  anchor.q_star[1] += 0.011;
  const EngageAnswer answer = judge();
  EXPECT_EQ(answer.verdict, EngageVerdict::kOutsideWindow);
  EXPECT_EQ(answer.index, 1);
  EXPECT_NEAR(answer.value, 5.5, 1e-12);
  anchor.q_star[1] = std::nan("");
  EXPECT_EQ(judge().verdict, EngageVerdict::kOutsideWindow);
  anchor.anchored = false;
  EXPECT_EQ(judge().verdict, EngageVerdict::kAccepted) << "nothing pulls";
}

TEST_F(EngageTest, WindowCountsTheWholeCoupledSpring) {
  settings.Z_q = (MatAA(2, 2) << 1000.0, 600.0, 600.0, 500.0).finished();
  anchor.q_star = two(0.1, 0.21);  // 6 N on the first, 5 N on the second
  const EngageAnswer answer = judge();
  EXPECT_EQ(answer.verdict, EngageVerdict::kOutsideWindow);
  EXPECT_EQ(answer.index, 0);
  EXPECT_NEAR(answer.value, 6.0, 1e-12);
}

TEST_F(EngageTest, HeldProxyNeedsAFreeOne) {
  was_free = false;
  anchor.q_star = sensed.q;
  expect_refused(EngageVerdict::kNeverFree, 0.0, 0.0);
  proxy.mode = ProxyMode::kPlanes;  // in the way: they say on which side of them the object is
  EXPECT_EQ(judge().verdict, EngageVerdict::kAccepted);
}

}  // namespace
}  // namespace haptic::core
