#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using core::LifecycleState;

/// Asks for force after `prepare`.
void expect_refused(const char* reason, const char* says,
                    const std::function<void(DeviceRig& rig)>& prepare) {
  SCOPED_TRACE(says);
  DeviceRig rig;
  rig.control();
  prepare(rig);
  EXPECT_EQ(rig.engage(), reason);
  EXPECT_NE(rig.refusal.find(says), std::string::npos) << rig.refusal;
  EXPECT_EQ(rig.newest().effort.tau_a[0], 0.0);
  EXPECT_EQ(rig.engage("nobody"), "NOT_CONTROLLER");
}

TEST(EngageRefusal, SaysWhatTheStreamLacks) {
  expect_refused("STREAM_STALE", "no proxy was accepted", [](DeviceRig&) {});
  expect_refused("STREAM_STALE", "must be finite", [](DeviceRig& rig) {
    for (int i = 0; i < 20; ++i) {
      EXPECT_EQ(rig.publish(std::nan("")), server::IngressVerdict::kNotFinite);
      rig.tick();
    }
  });
  expect_refused("STREAM_STALE", "less than 100 ms is needed", [](DeviceRig& rig) {
    rig.stream(300, 0.0);
    rig.tick(110);
  });
  expect_refused("TOO_FEW_SAMPLES", "at least 10 are needed", [](DeviceRig& rig) {
    for (int i = 0; i < 8; ++i) {
      rig.publish(0.0);
      rig.tick(30);
    }
  });
  expect_refused("STREAM_TOO_YOUNG", "at least 200 ms are needed",
                 [](DeviceRig& rig) { rig.stream(150, 0.0); });
  expect_refused("STREAM_TOO_YOUNG", "at least 200 ms are needed", [](DeviceRig& rig) {
    rig.stream(300, 0.0);
    rig.tick(101);  // a long gap restarts the wait
    rig.stream(50, 0.0);
  });
}

TEST(EngageRefusal, SaysWhatTheDeviceLacks) {
  expect_refused("DEVICE_STALE", "at most 3 ms is needed", [](DeviceRig& rig) {
    rig.stream(300, 0.0);
    rig.device->silent = true;
    rig.stream(5, 0.0);  // beyond 3 periods, below max_silence
  });
  expect_refused("OUTSIDE_WINDOW", "would start at 3 (N or N m): at most 2.5 is allowed",
                 [](DeviceRig& rig) { rig.stream(300, 0.03); });
  expect_refused("NOT_ARMED",
                 "the device is FAULT: force may be asked for in ARMED only; "
                 "clear the fault (hapticctl clear-fault)",
                 [](DeviceRig& rig) {
                   rig.stream(300, 0.0);
                   rig.sessions->emergency_stop("", [](const Outcome<Done>&) {});
                   rig.stream(2, 0.0);
                 });
  expect_refused("NOT_ARMED", "a Release came with it", [](DeviceRig& rig) {
    rig.stream(250, 0.01);
    rig.sessions->release("s1", [](const Outcome<Done>&) {});
  });
}

TEST(EngageRefusal, SaysThatSamplesComeTooFast) {
  DeviceRig rig;
  const auto reply = rig.ask({.session_id = "s1", .client_name = "alice", .nominal_rate_hz = 60.0});
  rig.tick(20);
  ASSERT_TRUE(reply->lease);
  rig.epoch = reply->lease->epoch;
  const std::string sentence =
      "980 samples/s come, 60 were announced: at most twice as many count as fresh";
  const auto queue = rig.sessions->subscribe("s1");
  for (int i = 0; i < 40; ++i) {  // as a client that waits for force; 50 samples in 51 ms
    rig.stream(50, 0.0);
    EXPECT_NE(rig.engage(), "");
  }
  EXPECT_EQ(rig.engage(), "TOO_FAST");
  EXPECT_EQ(rig.refusal, sentence);
  EXPECT_TRUE(rig.newest().limiters().has(core::Limiter::kTooFast));
  int told = 0;
  while (const auto event = queue->pop()) {
    told += event->reason == "TOO_FAST" ? 1 : 0;
  }
  EXPECT_EQ(told, 1) << "once, in the log too";
}

/// Session s1 has the lease.
class Engage : public testing::Test {
 protected:
  Engage() { rig.control(); }
  DeviceRig rig;
};

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

TEST_F(Engage, LateAnswerGrantsNothing) {
  rig.stream(250, 0.01);
  std::string reason = "(no answer)";
  const std::uint64_t ticket = rig.sessions->engage("s1", [&](const Outcome<Done>& outcome) {
    reason = outcome ? "" : outcome.refusal.reason.str();
  });
  rig.stream(1, 0.01);
  ASSERT_EQ(reason, "");
  // On its way the answer took so long that the client was told of a failure.
  rig.owner->post(server::Request{.id = ticket, .kind = server::Request::Kind::kCancel});
  rig.stream(1, 0.01);
  EXPECT_EQ(rig.state(), LifecycleState::kReleasing);
}

TEST_F(Engage, GivenUpRequestBringsNoForce) {
  rig.stream(250, 0.01);
  for (int i = 0; i < server::PendingRequests::kPatience; ++i) {  // their records wait
    rig.publish(0.01);
    rig.unit->tick(rig.now += DeviceRig::kTick, DeviceRig::kTick, {});
  }
  std::string reason = "(no answer)";
  rig.sessions->engage("s1", [&](const Outcome<Done>& outcome) {
    reason = outcome ? "" : outcome.refusal.reason.str();
  });
  rig.telemetry->drain();
  ASSERT_EQ(reason, "NO_ANSWER");
  rig.stream(50, 0.01);
  EXPECT_EQ(rig.state(), LifecycleState::kArmed);
}

}  // namespace
}  // namespace haptic::test
