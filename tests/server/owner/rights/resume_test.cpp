/// A lease that outlives its stream, and one that is taken away.

#include <gtest/gtest.h>

#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using core::LifecycleState;
using server::IngressVerdict;
using server::LeaseRequest;
using server::Priority;
using server::Refusal;

constexpr auto kLost = HandFront::Ending::kLost;

LeaseRequest resumable(const std::string& id, const std::string& client,
                       Priority priority = Priority::kPrimary) {
  return {.session_id = id,
          .client_name = client,
          .nominal_rate_hz = 1000.0,
          .priority = priority,
          .resumable = true};
}

LeaseRequest resuming(const std::string& id, const std::string& former) {
  LeaseRequest r = resumable(id, "alice");
  r.resume = former;
  return r;
}

class ResumeTest : public testing::Test {
 protected:
  std::shared_ptr<DeviceRig::Reply> ask(const LeaseRequest& wanted) { return rig.ask(wanted); }
  /// alice, resumable, with force of 1 N.
  void press() {
    rig.tick(3);
    const auto reply = ask(resumable("s1", "alice"));
    rig.tick(5);
    ASSERT_TRUE(reply->lease);
    rig.epoch = reply->lease->epoch;
    rig.press("s1");
    ASSERT_EQ(rig.state(), LifecycleState::kEngaged);
    ASSERT_EQ(rig.newest().life.gain, 1.0);
  }
  static long count(const std::vector<std::string>& all, const std::string& one) {
    return std::count(all.begin(), all.end(), one);
  }

  DeviceRig rig;
};

TEST_F(ResumeTest, KeepsAgeAndGainRaisesEpoch) {
  press();
  rig.sessions->close("s1", kLost);
  EXPECT_EQ(rig.publish(0.01), IngressVerdict::kAccepted) << "what was under way still counts";
  for (int i = 0; i < 30; ++i) {  // within fresh_end and hold_end
    rig.tick();
    EXPECT_EQ(rig.newest().life.gain, 1.0);
  }
  const core::Duration age = rig.newest().proxy.age;
  EXPECT_GE(age, 30ms);
  const auto reply = ask(resuming("s2", "s1"));
  ASSERT_TRUE(reply->lease);  // at once: nothing has to fade
  EXPECT_TRUE(reply->lease->resumed);
  EXPECT_EQ(reply->lease->epoch, 2U);
  EXPECT_EQ(reply->lease->newest_seq, rig.seq);
  rig.tick();
  EXPECT_EQ(rig.newest().life.gain, 1.0);
  EXPECT_EQ(rig.newest().proxy.age, age + 1ms);
  EXPECT_EQ(rig.sessions->state_of(rig.newest()).lease_epoch(), 2U);
  EXPECT_EQ(rig.publish(0.01), IngressVerdict::kOldEpoch);
  rig.epoch = rig.free_epoch = 2;
  const std::uint64_t newest = std::exchange(rig.seq, 0);
  EXPECT_EQ(rig.publish(0.01), IngressVerdict::kOldSequence) << "the sequence goes on";
  rig.seq = newest;
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(rig.publish(0.01), IngressVerdict::kAccepted);
    rig.tick();
    EXPECT_EQ(rig.state(), LifecycleState::kEngaged);
    EXPECT_NEAR(rig.newest().effort.tau_elastic[0], 1.0, 1e-9);
  }
}

TEST_F(ResumeTest, ForceComesBackInsideAnObject) {
  press();
  rig.sessions->close("s1", kLost);
  rig.tick(200);
  ASSERT_EQ(rig.state(), LifecycleState::kArmed) << "LOST";
  const auto again = ask(resuming("s2", "s1"));
  ASSERT_TRUE(again->lease);
  rig.epoch = rig.free_epoch = again->lease->epoch;
  rig.stream(250, 0.01);
  EXPECT_EQ(rig.engage("s2"), "") << "it was free in the session that it resumed";

  rig.sessions->close("s2", {});
  const auto bob = ask(resumable("s3", "bob"));
  rig.tick(300);
  ASSERT_TRUE(bob->lease);
  rig.epoch = rig.free_epoch = bob->lease->epoch;
  rig.stream(250, 0.01);
  EXPECT_EQ(rig.engage("s3"), "NEVER_FREE") << "a new session does not inherit it";
}

TEST_F(ResumeTest, GoneFrontDetachesEveryLease) {
  press();
  rig.owner->front_gone();
  EXPECT_TRUE(rig.sessions->status().detached);
  EXPECT_EQ(rig.sessions->status().sessions, 0U);
  rig.tick(10);
  EXPECT_EQ(rig.newest().life.gain, 1.0) << "the sample's age alone ends the force";
  const auto reply = ask(resuming("s2", "s1"));
  ASSERT_TRUE(reply->lease);
  EXPECT_TRUE(reply->lease->resumed);
  EXPECT_FALSE(rig.sessions->status().detached);
}

TEST_F(ResumeTest, UnresumableSessionEndsWithItsStream) {
  rig.control();
  rig.press();
  rig.sessions->close("s1", kLost);
  rig.tick(1);
  EXPECT_EQ(rig.state(), LifecycleState::kReleasing);
  EXPECT_EQ(rig.sessions->controller(), "");
}

TEST_F(ResumeTest, DeliberateLeaveCannotResume) {
  press();
  rig.sessions->close("s1");
  const auto reply = ask(resuming("s2", "s1"));
  EXPECT_FALSE(reply->lease);
  rig.tick(200);
  ASSERT_TRUE(reply->lease);
  EXPECT_FALSE(reply->lease->resumed);
}

TEST_F(ResumeTest, LostClientEndsForceThenLease) {
  press();
  const auto queue = rig.sessions->subscribe("observer");
  rig.sessions->close("s1", kLost);
  rig.tick(200);
  EXPECT_EQ(rig.newest().effort.tau_elastic[0], 0.0);
  EXPECT_TRUE(rig.sessions->status().detached);
  rig.tick(1800);
  EXPECT_FALSE(rig.sessions->status().detached);
  rig.tick(3);
  EXPECT_EQ(rig.state(), LifecycleState::kIdle);
  const auto all = reasons(*queue);
  EXPECT_EQ(count(all, "LEASE_DETACHED"), 1);
  EXPECT_EQ(count(all, "LEASE_EXPIRED"), 1);
  const auto reply = ask(resuming("s2", "s1"));
  ASSERT_TRUE(reply->lease);  // as any opening
  EXPECT_FALSE(reply->lease->resumed);
}

TEST_F(ResumeTest, ResumingIsNoSignOfLife) {
  press();
  int came_back = 0;
  for (; came_back < 5; ++came_back) {
    const std::string former = "s" + std::to_string(came_back + 1);
    rig.sessions->close(former, kLost);
    rig.tick(1900);
    if (!rig.sessions->status().detached) break;
    const auto reply = ask(resuming("s" + std::to_string(came_back + 2), former));
    ASSERT_TRUE(reply->lease && reply->lease->resumed);
    rig.tick(5);
  }
  // The first return started the clock anew, for a sample had come; the second did not.
  EXPECT_EQ(came_back, 2);
  rig.tick(3);
  EXPECT_EQ(rig.state(), LifecycleState::kIdle);
}

/// The Engage is posted, no tick has seen it yet, and its session is resumed: the answer was that
/// it failed, so it must not act.
TEST_F(ResumeTest, ResumingRefusesAPendingEngage) {
  rig.tick(3);
  const auto first = ask(resumable("s1", "alice"));
  rig.tick(5);
  ASSERT_TRUE(first->lease);
  rig.epoch = first->lease->epoch;
  rig.stream(250, 0.01);
  ASSERT_EQ(rig.state(), LifecycleState::kArmed);
  std::string reason = "(no answer)";
  rig.sessions->engage("s1", [&](const Outcome<Done>& outcome) {
    reason = outcome ? "" : outcome.refusal.reason.str();
  });
  const auto again = ask(resuming("s2", "s1"));
  ASSERT_TRUE(again->lease && again->lease->resumed);
  EXPECT_EQ(reason, "NOT_CONTROLLER");
  rig.epoch = again->lease->epoch;
  for (int i = 0; i < 50; ++i) {
    rig.stream(1, 0.01);
    ASSERT_EQ(rig.state(), LifecycleState::kArmed) << i;
    ASSERT_EQ(rig.newest().life.gain, 0.0);
  }
  EXPECT_EQ(rig.engage("s2"), "") << "a new one is heard";
}

TEST_F(ResumeTest, AnotherSessionsNameResumesNothing) {
  press();
  const auto reply = ask(resuming("s2", "guess"));
  ASSERT_TRUE(reply->refusal);
  EXPECT_EQ(reply->refusal->reason, "LEASE_HELD");
}

TEST_F(ResumeTest, DetachedDeviceFreesAtZeroForce) {
  press();
  rig.sessions->close("s1", kLost);
  const auto test = ask(resumable("s2", "tester", Priority::kTest));
  EXPECT_TRUE(test->refusal);  // it is of lower priority: only time helps
  const auto bob = ask(resumable("s3", "bob"));
  EXPECT_FALSE(bob->lease);
  EXPECT_EQ(rig.publish(0.01), IngressVerdict::kOldEpoch);
  const auto late = ask(resuming("s4", "s1"));
  ASSERT_TRUE(late->refusal);
  EXPECT_EQ(late->refusal->reason, "LEASE_HELD");
  rig.tick(200);
  ASSERT_TRUE(bob->lease);
  EXPECT_EQ(bob->lease->taken_from, "alice");
}

TEST_F(ResumeTest, SettingsSurvive) {
  press();
  server::SettingsRequest settings{.stiffness = {50.0}};
  ASSERT_TRUE(rig.sessions->update_settings("s1", settings));
  rig.sessions->close("s1", kLost);
  ASSERT_TRUE(ask(resuming("s2", "s1"))->lease);
  rig.tick();
  EXPECT_EQ(rig.newest().input.settings.stiffness[0], 50.0);
  settings.stiffness = {60.0};
  EXPECT_FALSE(rig.sessions->update_settings("s1", settings));
  EXPECT_TRUE(rig.sessions->update_settings("s2", settings));
}

TEST_F(ResumeTest, OnlyAHigherPriorityPreempts) {
  press();
  for (const Priority priority : {Priority::kTest, Priority::kPrimary}) {
    const auto reply = ask(resumable("s2", "bob", priority));
    ASSERT_TRUE(reply->refusal);
    EXPECT_EQ(reply->refusal->reason, "LEASE_HELD");
    const auto& details = reply->refusal->details;
    EXPECT_TRUE(std::any_of(details.begin(), details.end(), [](const Refusal::Detail& detail) {
      return detail.name == "holder" && detail.value == "alice";
    }));
  }
  EXPECT_TRUE(rig.sessions->holds_lease("s1"));
}

TEST_F(ResumeTest, PreemptionFadesThenAnswersAtZero) {
  press();
  const auto queue = rig.sessions->subscribe("s1");
  const auto boss = ask(resumable("s2", "boss", Priority::kOperator));
  EXPECT_FALSE(boss->lease);
  EXPECT_EQ(rig.publish(0.02), IngressVerdict::kOldEpoch);  // from this moment on
  int ticks = 0;
  for (; !boss->lease && ticks < 300; ++ticks) {
    rig.tick();
    const core::TickRecord record = rig.newest();
    EXPECT_EQ(rig.sessions->state_of(record).lease_epoch(), 2U);  // the epoch rose at once
    EXPECT_EQ(boss->lease.has_value(), record.life.gain == 0.0);
    EXPECT_NE(record.life.state, LifecycleState::kIdle);  // never disarmed in between
  }
  EXPECT_GT(ticks, 50);  // 80 ms of fade, not a drop
  ASSERT_TRUE(boss->lease);
  EXPECT_EQ(boss->lease->epoch, 2U);
  EXPECT_EQ(boss->lease->taken_from, "alice");
  rig.tick(2);
  EXPECT_EQ(rig.state(), LifecycleState::kArmed);
  EXPECT_EQ(rig.engage("s1"), "NOT_CONTROLLER");
  const auto all = reasons(*queue);
  EXPECT_EQ(count(all, "LEASE_PREEMPTED"), 1);
  EXPECT_EQ(count(all, "LEASE_GRANTED"), 1);
}

TEST_F(ResumeTest, APreemptedHolderCannotResume) {
  press();
  const auto boss = ask(resumable("s2", "boss", Priority::kOperator));
  const auto back = ask(resuming("s3", "s1"));
  ASSERT_TRUE(back->refusal);
  EXPECT_NE(back->refusal->message.view().find("'boss'"), std::string::npos);
  rig.tick(200);
  EXPECT_TRUE(boss->lease);
}

TEST_F(ResumeTest, ClosingEndsAPromisedLease) {
  press();
  const auto boss = ask(resumable("s2", "boss", Priority::kOperator));
  EXPECT_EQ(rig.sessions->controller(), "boss") << "promised";
  rig.owner->begin_closing();
  ASSERT_TRUE(boss->refusal);
  EXPECT_EQ(rig.sessions->controller(), "");
}

TEST_F(ResumeTest, WaitingOperatorLeavesAFreeDevice) {
  press();
  const auto boss = ask(resumable("s2", "boss", Priority::kOperator));
  rig.sessions->close("s2", kLost);
  rig.tick(200);
  EXPECT_FALSE(boss->lease);
  EXPECT_EQ(rig.sessions->controller(), "");
  EXPECT_EQ(rig.state(), LifecycleState::kIdle);
  EXPECT_EQ(rig.newest().input.settings.stiffness[0], 100.0);
}

TEST_F(ResumeTest, HigherPriorityOvertakesAWaitingClient) {
  rig.tick(3);
  ASSERT_TRUE(ask(resumable("s1", "alice", Priority::kTest))->lease);
  rig.tick(5);
  rig.epoch = 1;
  rig.press("s1");
  const auto bob = ask(resumable("s2", "bob"));
  rig.tick(3);
  const auto boss = ask(resumable("s3", "boss", Priority::kOperator));
  ASSERT_TRUE(bob->refusal);
  EXPECT_EQ(bob->refusal->reason, "LEASE_HELD");
  rig.tick(200);
  ASSERT_TRUE(boss->lease);
  EXPECT_EQ(boss->lease->taken_from, "alice");
}

TEST_F(ResumeTest, ResumingSessionsHaveBoundedPlaces) {
  press();
  server::Request again{.kind = server::Request::Kind::kAdmitSession,
                        .session_id = rig.sessions->id_of("s1")};
  for (int i = 0; i < 200; ++i) {
    ++again.id;
    rig.owner->post(again);
  }
  EXPECT_EQ(rig.sessions->status().sessions, 64U) << "twice the limit of 32";
}

}  // namespace
}  // namespace haptic::test
