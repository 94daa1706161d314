#include "core/src/tick/proxy_intake.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using std::chrono::milliseconds;

/// A held proxy of the lease 1 in every tick.
class ProxyIntakeTest : public testing::Test {
 protected:
  ProxyIntakeTest() {
    in.command.lease_held = true;
    in.command.tenure = newest.tenure = 1;
    newest.mode = ProxyMode::kHeld;
    newest.x = two(0.1, 0.2);
  }
  ProxyInUse step(LifecycleState last = LifecycleState::kEngaged, int age_ms = 0) {
    in.now += milliseconds(1);
    newest.born = in.now - milliseconds(age_ms);
    ++newest.seq;
    return proxy.step(in, newest, limits, tracker, last);
  }
  ProxyIntake proxy{2};
  StalenessLimits limits{};
  TrackerRecord tracker{};
  ProxySnapshot newest{};
  TickInput in{.now = TimePoint(milliseconds(1000))};
};

TEST_F(ProxyIntakeTest, NewestSampleLeads) {
  const ProxyInUse now = step(LifecycleState::kArmed);
  EXPECT_EQ(now.mode, ProxyMode::kHeld);
  EXPECT_EQ(now.tenure, newest.tenure);
  EXPECT_EQ(now.seq, 1u);
  EXPECT_EQ(now.level, Staleness::kFresh);
  EXPECT_EQ(now.ladder, 1.0);
  EXPECT_EQ(proxy.sample().x, two(0.1, 0.2));
}

TEST_F(ProxyIntakeTest, SampleIsReadOnce) {
  static_cast<void>(step(LifecycleState::kArmed));
  --newest.seq;
  newest.x = two(0.3, 0.4);
  static_cast<void>(step(LifecycleState::kArmed));
  EXPECT_EQ(proxy.sample().x, two(0.1, 0.2));
  newest.mode = ProxyMode::kPlanes;
  static_cast<void>(proxy.step(in, newest, limits, tracker, LifecycleState::kArmed));
  EXPECT_EQ(proxy.sample().x, two(0.3, 0.4));
}

TEST_F(ProxyIntakeTest, LadderFallsWithAge) {
  EXPECT_EQ(step(LifecycleState::kArmed, 99).ladder, 1.0);
  const ProxyInUse fading = step(LifecycleState::kArmed, 140);
  EXPECT_EQ(fading.level, Staleness::kFade);
  EXPECT_DOUBLE_EQ(fading.ladder, 0.5) << "half-way from 100 to 180 ms";
  EXPECT_EQ(step(LifecycleState::kArmed, 180).level, Staleness::kLost);
}

TEST_F(ProxyIntakeTest, LadderIsNeverAboveTheTrackers) {
  tracker.on = true;
  tracker.ladder = 0.25;
  EXPECT_EQ(step().ladder, 0.0) << "no sample was taken under force";
  EXPECT_EQ(step(LifecycleState::kArmed).ladder, 0.25);
  tracker.ladder = 1.0;
  EXPECT_DOUBLE_EQ(step(LifecycleState::kArmed, 140).ladder, 0.5);
}

TEST_F(ProxyIntakeTest, NextLeaseNeverLeadsFadingForce) {
  static_cast<void>(step(LifecycleState::kArmed));
  in.command.tenure = newest.tenure = 2;
  newest.x = two(9.0, 9.0);
  for (const LifecycleState state :
       {LifecycleState::kEngaging, LifecycleState::kEngaged, LifecycleState::kReleasing}) {
    EXPECT_EQ(step(state).seq, 1u) << name(state);
    EXPECT_EQ(proxy.sample().x, two(0.1, 0.2));
  }
  EXPECT_EQ(step(LifecycleState::kArmed).seq, 5u);
  EXPECT_EQ(proxy.sample().x, two(9.0, 9.0));
}

TEST_F(ProxyIntakeTest, LeaseEndForgetsOnlyWithoutForce) {
  static_cast<void>(step(LifecycleState::kArmed));
  in.command.lease_held = false;
  EXPECT_EQ(step(LifecycleState::kReleasing).mode, ProxyMode::kHeld);
  EXPECT_EQ(step(LifecycleState::kIdle).mode, ProxyMode::kNone);
  EXPECT_EQ(proxy.sample().mode, ProxyMode::kNone);
}

TEST_F(ProxyIntakeTest, RefusesASampleOfAnotherTenure) {
  newest.tenure = 3;
  EXPECT_EQ(step(LifecycleState::kArmed).mode, ProxyMode::kNone);
}

TEST_F(ProxyIntakeTest, BadSampleIsNotTaken) {
  static_cast<void>(step());
  newest.mode = ProxyMode::kPlanes;
  newest.planes.normals = MatXQ::Identity(2, 2);
  newest.planes.offsets = two(0.3, 0.4);
  const ProxySnapshot good = newest;
  static_cast<void>(step(LifecycleState::kArmed));
  const std::uint64_t taken = newest.seq;
  const auto spoil = [&](auto change) {
    const std::uint64_t seq = newest.seq;
    newest = good;
    newest.seq = seq;
    change(newest);
    return step(LifecycleState::kEngaged).seq;
  };
  EXPECT_EQ(spoil([](ProxySnapshot& p) { p.x = one(0.1); }), taken);
  EXPECT_EQ(spoil([](ProxySnapshot& p) { p.x[1] = std::nan(""); }), taken);
  EXPECT_EQ(spoil([](ProxySnapshot& p) { p.planes.offsets.conservativeResize(1); }), taken);
  EXPECT_EQ(spoil([](ProxySnapshot& p) { p.planes.normals(0, 0) = std::nan(""); }), taken);
  EXPECT_EQ(spoil([](ProxySnapshot& p) { p.planes.offsets[0] = HUGE_VAL; }), taken);
  EXPECT_EQ(spoil([](ProxySnapshot& p) { p.planes.compliance = one(1.0); }), taken);
  EXPECT_EQ(spoil([](ProxySnapshot& p) { p.planes.velocity = two(0.0, std::nan("")); }), taken);
  EXPECT_EQ(spoil([](ProxySnapshot& p) { p.planes.curved[1] = 2; }), taken);
  EXPECT_EQ(spoil([](ProxySnapshot& p) {
              p.planes.curvature = one(1.0);
              p.planes.curved[1] = 1;
              p.planes.first[1] = 2;
            }),
            taken);
  EXPECT_EQ(spoil([](ProxySnapshot&) {}), newest.seq) << "and the good one is";
  EXPECT_EQ(spoil([](ProxySnapshot& p) {
              p.mode = ProxyMode::kFree;
              p.x = one(std::nan(""));
            }),
            newest.seq)
      << "free: x is not read";
}

}  // namespace
}  // namespace haptic::core
