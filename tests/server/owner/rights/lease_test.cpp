#include <gtest/gtest.h>

#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using core::LifecycleState;
using server::DeviceEvent;
using server::IngressVerdict;
using server::LeaseRequest;
using server::Refusal;

LeaseRequest request(const std::string& id, const std::string& name) {
  return {.session_id = id, .client_name = name, .nominal_rate_hz = 60.0};
}

bool contains(const std::vector<std::string>& all, const std::string& one) {
  return std::find(all.begin(), all.end(), one) != all.end();
}

TEST(Lease, FreeDeviceIsGrantedAndArms) {
  DeviceRig rig;
  const auto reply = rig.ask(request("s1", "alice"));
  ASSERT_TRUE(reply->lease.has_value()) << "before the loop ticks";
  EXPECT_EQ(reply->lease->epoch, 1U);
  EXPECT_EQ(rig.sessions->controller(), "alice");
  rig.tick(5);
  EXPECT_EQ(rig.state(), LifecycleState::kArmed);
}

TEST(Lease, SecondControllerLearnsTheHoldersName) {
  DeviceRig rig;
  rig.control("s1", "alice");
  const auto reply = rig.ask(request("s2", "bob"));
  ASSERT_TRUE(reply->refusal.has_value());
  EXPECT_EQ(reply->refusal->code, Refusal::Code::kExists);
  EXPECT_EQ(reply->refusal->reason, "LEASE_HELD");
  EXPECT_NE(reply->refusal->message.view().find("'alice'"), std::string::npos);
  rig.tick(10);
  EXPECT_EQ(rig.sessions->controller(), "alice");
}

TEST(Lease, ExpiresFromItsOpeningWithoutSamples) {
  DeviceRig rig;
  rig.tick(5);
  const auto reply = rig.ask(request("s1", "alice"));
  const auto queue = rig.sessions->subscribe("s1");
  rig.tick(1999);
  EXPECT_TRUE(rig.sessions->holds_lease("s1"));
  rig.tick(1);
  EXPECT_FALSE(rig.sessions->holds_lease("s1"));
  EXPECT_TRUE(contains(reasons(*queue), "LEASE_EXPIRED"));
  rig.tick(5);
  EXPECT_EQ(rig.state(), LifecycleState::kIdle);
}

TEST(Lease, ExpiresFromTheLastAcceptedSample) {
  DeviceRig rig;
  rig.control();
  rig.stream(3000, 0.0);  // the last one is published one tick before `now`
  rig.tick(1998);
  EXPECT_TRUE(rig.sessions->holds_lease("s1"));
  rig.tick(1);
  EXPECT_FALSE(rig.sessions->holds_lease("s1"));
}

TEST(Lease, InvalidSamplesDoNotRenewIt) {
  DeviceRig rig;
  rig.control();
  rig.press();
  ASSERT_EQ(rig.state(), LifecycleState::kEngaged);
  const std::uint64_t newest = rig.seq;
  for (int i = 1; i <= 2000; ++i) {
    const bool held = rig.sessions->holds_lease("s1");
    rig.seq = newest - 1;
    EXPECT_EQ(rig.publish(0.01), held ? IngressVerdict::kOldSequence : IngressVerdict::kOldEpoch);
    rig.seq = newest + 1000;
    EXPECT_EQ(rig.publish(2000.0), held ? IngressVerdict::kOutOfBounds : IngressVerdict::kOldEpoch);
    rig.tick();
    if (i > 200) {
      ASSERT_EQ(rig.newest().effort.tau_elastic[0], 0.0);
    }
  }
  EXPECT_FALSE(rig.sessions->holds_lease("s1"));
  rig.tick(2);
  EXPECT_EQ(rig.state(), LifecycleState::kIdle);
  EXPECT_EQ(rig.device->force, 0.0);
}

TEST(Lease, ExpiredHolderBecomesAnObserver) {
  DeviceRig rig;
  const auto queue = rig.sessions->subscribe("s1");
  rig.control();
  EXPECT_EQ(rig.sessions->observers(), 0U);
  rig.tick(2100);
  EXPECT_EQ(rig.sessions->observers(), 1U);
  EXPECT_EQ(rig.sessions->controller(), "");
  EXPECT_EQ(rig.publish(0.0), IngressVerdict::kOldEpoch);
  EXPECT_EQ(rig.engage(), "NOT_CONTROLLER");
  static_cast<void>(reasons(*queue));
  rig.control("s2", "bob");
  EXPECT_TRUE(contains(reasons(*queue), "IDLE -> ARMED"));  // it still hears what happens
}

TEST(Lease, LostHolderEndsForceInTime) {
  DeviceRig rig;
  rig.control();
  rig.press();
  ASSERT_EQ(rig.state(), LifecycleState::kEngaged);
  ASSERT_NEAR(rig.newest().effort.tau_elastic[0], 1.0, 1e-9);
  rig.sessions->close("s1");
  double last = 1.0;
  int ticks = 0;
  while (rig.newest().effort.tau_elastic[0] != 0.0 && ticks < 1000) {
    rig.tick();
    ++ticks;
    EXPECT_LE(rig.newest().effort.tau_elastic[0], last);
    last = rig.newest().effort.tau_elastic[0];
  }
  EXPECT_LT(ticks, 200);
  EXPECT_GT(ticks, 10);  // faded, not dropped
  rig.tick(2);
  EXPECT_EQ(rig.state(), LifecycleState::kIdle);
}

TEST(Lease, NewcomerWaitsForZeroForce) {
  DeviceRig rig;
  rig.control("s1", "alice");
  rig.press();
  rig.sessions->close("s1");
  const auto bob = rig.ask(request("s2", "bob"));
  EXPECT_FALSE(bob->lease.has_value());
  const auto carol = rig.ask(request("s3", "carol"));
  ASSERT_TRUE(carol->refusal.has_value());
  EXPECT_NE(carol->refusal->message.view().find("'bob'"), std::string::npos);
  for (int i = 0; i < 200 && !bob->lease; ++i) {
    rig.tick();
    EXPECT_EQ(bob->lease.has_value(), rig.newest().life.gain == 0.0);
  }
  ASSERT_TRUE(bob->lease.has_value());
  EXPECT_EQ(bob->lease->epoch, 2U);
  rig.tick(5);
  EXPECT_EQ(rig.state(), LifecycleState::kArmed);
}

TEST(Lease, WaitingNewcomerMayLeave) {
  DeviceRig rig;
  rig.control();
  rig.press();
  rig.sessions->close("s1");
  const auto bob = rig.ask(request("s2", "bob"));
  rig.sessions->close("s2");
  ASSERT_TRUE(bob->refusal.has_value()) << "the front keeps the call until it is answered";
  rig.tick(300);
  EXPECT_FALSE(bob->lease.has_value());
  EXPECT_EQ(rig.sessions->controller(), "");
  EXPECT_EQ(rig.control("s3").epoch, 2U);
}

TEST(Lease, LimitsMayBeTightenedNeverWidened) {
  DeviceRig rig;
  LeaseRequest r = request("s1", "alice");
  r.hold_end = 60ms;
  r.fade_end = 10s;
  const auto reply = rig.ask(r);
  ASSERT_TRUE(reply->lease.has_value());
  EXPECT_EQ(reply->lease->staleness.hold_end, 60ms);
  EXPECT_EQ(reply->lease->staleness.fade_end, 180ms);
  // 2.5 periods of 60 Hz
  EXPECT_NEAR(core::seconds(reply->lease->staleness.fresh_end), 2.5 / 60.0, 1e-6);
}

TEST(Lease, NamesInconsistentLimits) {
  DeviceRig rig;
  LeaseRequest r = request("s1", "alice");
  r.fade_end = 120ms;  // hold_end is 100 ms: a fade of 20 ms is a jerk
  const auto reply = rig.ask(r);
  ASSERT_TRUE(reply->refusal.has_value());
  EXPECT_EQ(reply->refusal->code, Refusal::Code::kInvalid);
  EXPECT_NE(reply->refusal->field.view().find("fade_end"), std::string::npos);
  EXPECT_NE(reply->refusal->message.view().find("120"), std::string::npos);
  for (const double rate : {0.0, 0.5, 2001.0, -1.0, std::nan("")}) {
    LeaseRequest wrong = request("s1", "alice");
    wrong.nominal_rate_hz = rate;
    const auto answer = rig.ask(wrong);
    ASSERT_TRUE(answer->refusal.has_value()) << rate;
    EXPECT_EQ(answer->refusal->field, "nominal_rate_hz");
  }
}

TEST(Lease, ClosingRefusesNewcomersAndTellsEveryone) {
  DeviceRig rig;
  const auto queue = rig.sessions->subscribe("s1");
  rig.control();
  rig.press();
  rig.owner->begin_closing();
  rig.tick(300);
  EXPECT_EQ(rig.state(), LifecycleState::kClosing);
  EXPECT_EQ(rig.device->force, 0.0);
  EXPECT_TRUE(contains(reasons(*queue), "CLOSING"));
  const auto reply = rig.ask(request("s2", "bob"));
  ASSERT_TRUE(reply->refusal.has_value());
  EXPECT_EQ(reply->refusal->code, Refusal::Code::kUnavailable);
}

TEST(Lease, EndedLoopRefusesWaitingRequests) {
  DeviceRig rig;
  rig.control();
  std::vector<std::string> answers;
  const auto engage = [&] {
    rig.sessions->engage("s1", [&](const Outcome<Done>& outcome) {
      answers.push_back(outcome ? "" : outcome.refusal.reason.str());
    });
  };
  engage();
  EXPECT_EQ(answers.size(), 0U);
  rig.owner->begin_closing();
  rig.owner->loop_ended();
  EXPECT_EQ(answers, std::vector<std::string>{"CLOSING"});
  engage();
  EXPECT_EQ(answers.size(), 2U) << "at once";
}

}  // namespace
}  // namespace haptic::test
