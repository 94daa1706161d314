#include <gtest/gtest.h>

#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using core::LifecycleState;

/// Session s1 has the lease.
class Engage : public testing::Test {
 protected:
  Engage() { rig.control(); }
  DeviceRig rig;
};

TEST_F(Engage, NeedsTheLease) {
  EXPECT_EQ(rig.engage("nobody"), "NOT_CONTROLLER");
}

TEST_F(Engage, NeedsAStreamAtAll) {
  EXPECT_EQ(rig.engage(), "STREAM_STALE");
}

TEST_F(Engage, NeedsTenSamples) {
  for (int i = 0; i < 8; ++i) {
    rig.publish(0.0);
    rig.tick(30);
  }
  EXPECT_EQ(rig.engage(), "TOO_FEW_SAMPLES");
  EXPECT_NE(rig.refusal.find("10"), std::string::npos);
}

TEST_F(Engage, Needs200MillisecondsWithoutAGap) {
  rig.stream(150, 0.0);
  EXPECT_EQ(rig.engage(), "STREAM_TOO_YOUNG");
  EXPECT_NE(rig.refusal.find("200"), std::string::npos);
}

TEST_F(Engage, LongGapRestartsTheWait) {
  rig.stream(300, 0.0);
  rig.tick(101);
  rig.stream(50, 0.0);
  EXPECT_EQ(rig.engage(), "STREAM_TOO_YOUNG");
}

TEST_F(Engage, NeedsAProxyBeforeHoldEnd) {
  rig.stream(300, 0.0);
  rig.tick(110);
  EXPECT_EQ(rig.engage(), "STREAM_STALE");
}

TEST_F(Engage, NeedsAFreshDeviceSample) {
  rig.stream(300, 0.0);
  rig.device->silent = true;
  rig.stream(5, 0.0);  // beyond 3 periods, below max_silence
  EXPECT_EQ(rig.engage(), "DEVICE_STALE");
}

TEST_F(Engage, NeedsForceWithinTheStartWindow) {
  rig.stream(300, 0.03);  // 3 N, the window is 2.5 N
  EXPECT_EQ(rig.engage(), "OUTSIDE_WINDOW");
  EXPECT_NE(rig.refusal.find("3 "), std::string::npos);
  EXPECT_NE(rig.refusal.find("2.5"), std::string::npos);
  EXPECT_EQ(rig.newest().effort.tau_a[0], 0.0);
}

TEST_F(Engage, HeldProxyNeedsAFreeOne) {
  rig.free_epoch = rig.epoch;
  rig.stream(300, 0.01);
  EXPECT_EQ(rig.engage(), "NEVER_FREE");
  EXPECT_NE(rig.refusal.find("free for a few samples"), std::string::npos);
  EXPECT_TRUE(rig.newest().limiters().has(core::Limiter::kNeverFree));
  rig.free_epoch = 0;  // the next sample is free
  rig.stream(2, 0.01);
  EXPECT_FALSE(rig.newest().limiters().has(core::Limiter::kNeverFree));
  EXPECT_EQ(rig.engage(), "");
}

TEST_F(Engage, NeedsArmed) {
  rig.stream(300, 0.0);
  rig.sessions->emergency_stop("", [](const Outcome<Done>&) {});
  rig.stream(2, 0.0);
  EXPECT_EQ(rig.engage(), "NOT_ARMED");
  EXPECT_NE(rig.refusal.find("FAULT"), std::string::npos);
}

TEST_F(Engage, RampsUpAndReleaseRampsDown) {
  rig.stream(250, 0.01);
  EXPECT_EQ(rig.engage(), "");
  EXPECT_EQ(rig.state(), LifecycleState::kEngaging);
  rig.stream(250, 0.01);
  EXPECT_EQ(rig.state(), LifecycleState::kEngaged);
  EXPECT_NEAR(rig.device->force, 1.0, 1e-9);
  bool released = false;
  rig.sessions->release("s1", [&](const Outcome<Done>& outcome) { released = bool(outcome); });
  rig.stream(1, 0.01);
  EXPECT_TRUE(released);
  EXPECT_EQ(rig.state(), LifecycleState::kReleasing);
  rig.stream(200, 0.01);
  EXPECT_EQ(rig.state(), LifecycleState::kArmed);
  EXPECT_EQ(rig.device->force, 0.0);
}

TEST_F(Engage, ReleaseIsIdempotent) {
  for (int i = 0; i < 2; ++i) {
    bool released = false;
    rig.sessions->release("s1", [&](const Outcome<Done>& outcome) { released = bool(outcome); });
    rig.tick();
    EXPECT_TRUE(released);
  }
  EXPECT_EQ(rig.state(), LifecycleState::kArmed);
}

TEST_F(Engage, LostForceNeedsAnotherRequest) {
  const auto queue = rig.sessions->subscribe("s1");
  rig.press();
  rig.tick(200);
  EXPECT_EQ(rig.state(), LifecycleState::kArmed);
  bool lost = false;
  while (auto event = queue->pop()) lost |= event->kind == server::DeviceEvent::Kind::kLost;
  EXPECT_TRUE(lost);
  rig.stream(400, 0.01);
  EXPECT_EQ(rig.device->force, 0.0);
  EXPECT_EQ(rig.engage(), "");
}

TEST_F(Engage, BurstDoesNotSaveFadingForce) {
  rig.press();
  rig.tick(150);  // fading: 50 of 80 ms
  const double before = rig.newest().life.gain;
  ASSERT_LT(before, 0.5);
  for (int i = 0; i < 150; ++i) rig.publish(0.01);
  rig.tick();
  EXPECT_LT(rig.newest().life.gain, before);
  EXPECT_EQ(rig.newest().input.proxy.seq, rig.seq);  // but where it is, is the newest
}

TEST_F(Engage, LeaseEndRefusesAPendingRequest) {
  std::string reason;
  rig.sessions->engage("s1",
                       [&](const Outcome<Done>& outcome) { reason = outcome.refusal.reason; });
  rig.sessions->close("s1");
  EXPECT_EQ(reason, "NOT_CONTROLLER");
}

TEST_F(Engage, AbandonedRequestBringsNoForce) {
  rig.stream(250, 0.01);
  bool answered = false;
  const std::uint64_t ticket =
      rig.sessions->engage("s1", [&](const Outcome<Done>&) { answered = true; });
  // No tick came in time.
  rig.owner->post(server::Request{.id = ticket, .kind = server::Request::Kind::kCancel});
  rig.stream(300, 0.01);
  EXPECT_FALSE(answered);
  EXPECT_EQ(rig.state(), core::LifecycleState::kArmed);
  EXPECT_EQ(rig.newest().life.gain, 0.0);
  EXPECT_EQ(rig.engage(), "") << "the next one is as good as ever";
}

TEST_F(Engage, SameTickReleaseRefusesIt) {
  rig.stream(250, 0.01);
  rig.sessions->release("s1", [](const Outcome<Done>&) {});
  EXPECT_EQ(rig.engage(), "NOT_ARMED");
  EXPECT_NE(rig.refusal.find("Release"), std::string::npos) << rig.refusal;
  EXPECT_EQ(rig.state(), core::LifecycleState::kArmed);
}

TEST_F(Engage, NamesWhySamplesWereRefused) {
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(rig.publish(std::nan("")), server::IngressVerdict::kNotFinite);
    rig.tick();
  }
  EXPECT_EQ(rig.engage(), "STREAM_STALE");
  EXPECT_NE(rig.refusal.find("must be finite"), std::string::npos) << rig.refusal;
}

}  // namespace
}  // namespace haptic::test
