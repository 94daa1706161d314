#include <gtest/gtest.h>

#include "server/owner/rights/pending_requests.hpp"
#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using core::Fault;
using core::FaultSet;
using core::LifecycleState;
using server::DeviceEvent;
using server::Refusal;

FaultSet only(Fault fault) {
  FaultSet set;
  set.set(fault);
  return set;
}

TEST(EmergencyStop, ZeroesTheCommandWithinTwoTicks) {
  DeviceRig rig;
  rig.control();
  rig.press();
  ASSERT_GT(rig.device->force, 0.5);
  bool stopped = false;
  rig.sessions->emergency_stop("button", [&](const Outcome<Done>& o) { stopped = bool(o); });
  EXPECT_FALSE(stopped);  // nobody claims what the loop has not done
  rig.stream(2, 0.01);
  EXPECT_TRUE(stopped);
  EXPECT_EQ(rig.state(), LifecycleState::kFault);
  EXPECT_EQ(rig.device->force, 0.0);
}

TEST(EmergencyStop, EventCarriesTheGivenReason) {
  DeviceRig rig;
  rig.tick(3);
  const auto queue = rig.sessions->subscribe("watcher");
  rig.sessions->emergency_stop("finger stuck", [](const Outcome<Done>&) {});
  rig.tick();
  bool seen = false;
  while (auto event = queue->pop()) {
    if (event->kind != DeviceEvent::Kind::kFault) continue;
    seen = true;
    EXPECT_EQ(event->reason, "EMERGENCY_STOP");
    EXPECT_NE(event->message.view().find("finger stuck"), std::string::npos);
  }
  EXPECT_TRUE(seen);
}

TEST(EmergencyStop, LocalOneIsClearedLocallyOnly) {
  DeviceRig rig;
  rig.tick(3);
  using Kind = server::Request::Kind;
  const auto ask = [&](Kind kind, bool local) {
    server::Answer answer;
    rig.sessions->ask({.kind = kind, .local = local}, [&](const server::Answer& a) { answer = a; });
    rig.tick(3);
    return answer.refusal ? answer.refusal->reason.str() : std::string();
  };
  EXPECT_EQ(ask(Kind::kStop, true), "");
  EXPECT_EQ(ask(Kind::kStop, false), "") << "a later one from afar changes nothing";
  EXPECT_EQ(ask(Kind::kClear, false), "STOPPED_LOCALLY");
  EXPECT_EQ(rig.state(), LifecycleState::kFault);
  EXPECT_EQ(ask(Kind::kClear, true), "");
  EXPECT_EQ(rig.state(), LifecycleState::kIdle);
  EXPECT_EQ(ask(Kind::kStop, false), "");
  EXPECT_EQ(ask(Kind::kClear, false), "");
}

TEST(EmergencyStop, LocalOneOutlastsAnEarlierClear) {
  DeviceRig rig;
  rig.tick(3);
  using Kind = server::Request::Kind;
  std::string reasons;
  const auto ask = [&](Kind kind, bool local) {
    rig.sessions->ask({.kind = kind, .local = local}, [&reasons, kind](const server::Answer& a) {
      if (kind == Kind::kClear) reasons += (a.refusal ? a.refusal->reason.str() : "ok") + " ";
    });
  };
  ask(Kind::kStop, false);
  rig.tick();
  ask(Kind::kStop, true);
  ask(Kind::kClear, true);  // it has not seen the local stop
  rig.tick();
  ask(Kind::kClear, false);
  EXPECT_EQ(reasons, "FAULT_PERSISTS STOPPED_LOCALLY ");
  rig.tick();
  EXPECT_EQ(rig.state(), LifecycleState::kFault);
}

TEST(ClearFault, FaultStaysUntilCleared) {
  DeviceRig rig;
  rig.tick(3);
  rig.sessions->emergency_stop("", [](const Outcome<Done>&) {});
  rig.tick(5000);
  ASSERT_EQ(rig.state(), LifecycleState::kFault);
  std::optional<FaultSet> cleared;
  rig.sessions->clear_faults({}, [&](const Outcome<FaultSet>& o) { cleared = o.value; });
  rig.tick(2);
  ASSERT_TRUE(cleared.has_value());
  EXPECT_EQ(*cleared, only(Fault::kEmergencyStop));
  EXPECT_EQ(rig.state(), LifecycleState::kIdle);
}

TEST(ClearFault, NamesThePersistingCause) {
  DeviceRig rig;
  rig.tick(3);
  rig.device->lost = true;
  rig.tick(2);
  ASSERT_TRUE(rig.newest().faults().has(Fault::kDeviceLost));
  Refusal refusal;
  rig.sessions->clear_faults({}, [&](const Outcome<FaultSet>& o) { refusal = o.refusal; });
  rig.tick(1);
  EXPECT_EQ(refusal.code, Refusal::Code::kPrecondition);
  EXPECT_EQ(refusal.reason, "FAULT_PERSISTS");
  EXPECT_NE(refusal.message.view().find("DEVICE_LOST"), std::string::npos);
  EXPECT_EQ(rig.state(), LifecycleState::kFault);
}

TEST(ClearFault, TwoRequestsClearBothFaults) {
  DeviceRig rig;
  rig.tick(3);
  rig.device->lost = true;
  rig.sessions->emergency_stop("", [](const Outcome<Done>&) {});
  rig.tick(2);
  rig.device->lost = false;
  rig.tick(2);
  int answers = 0;
  const auto count = [&](const Outcome<FaultSet>& o) { answers += o ? 1 : 0; };
  rig.sessions->clear_faults(only(Fault::kDeviceLost), count);
  rig.sessions->clear_faults(only(Fault::kEmergencyStop), count);
  rig.tick(2);
  EXPECT_EQ(answers, 2);
  EXPECT_FALSE(rig.newest().faults().any());
}

TEST(ClearFault, WaitingRequestClearsNoLaterStop) {
  DeviceRig rig;
  rig.tick(3);
  rig.sessions->emergency_stop("first", [](const Outcome<Done>&) {});
  rig.tick(2);
  std::string reasons;
  const auto note = [&](const Outcome<FaultSet>& o) {
    reasons += (o ? "ok" : o.refusal.reason.str()) + " ";
  };
  rig.sessions->clear_faults({}, note);
  rig.sessions->clear_faults({}, note);
  rig.sessions->emergency_stop("second", [](const Outcome<Done>&) {});
  rig.tick(5);
  EXPECT_EQ(reasons, "FAULT_PERSISTS FAULT_PERSISTS ");
  EXPECT_EQ(rig.state(), LifecycleState::kFault);
}

TEST(ClearFault, InactiveFaultClearsNothing) {
  DeviceRig rig;
  rig.tick(3);
  std::optional<FaultSet> cleared;
  rig.sessions->clear_faults(only(Fault::kLoopLate),
                             [&](const Outcome<FaultSet>& o) { cleared = o.value; });
  ASSERT_TRUE(cleared.has_value());
  EXPECT_FALSE(cleared->any());
}

server::Request stop() {
  return {.id = 7, .kind = server::Request::Kind::kStop};
}

TEST(Pending, GivesUpAfterABoundedTime) {
  server::PendingRequests pending;
  pending.add(stop(), 1);
  server::PendingRequests::Answers answers;
  const core::TickRecord silent{};
  for (int i = 0; i < server::PendingRequests::kPatience - 1; ++i) pending.step(silent, answers);
  EXPECT_TRUE(answers.empty());
  pending.step(silent, answers);
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(answers[0].id, 7U);
  EXPECT_EQ(answers[0].refusal->reason, "NO_ANSWER");
}

TEST(Pending, EngageIsTakenBackOnce) {
  server::PendingRequests pending;
  pending.add({.id = 7, .kind = server::Request::Kind::kEngage}, 1);
  core::TickRecord record;
  record.life.engage = {.id = 1, .verdict = core::EngageVerdict::kAccepted};
  server::PendingRequests::Answers answers;
  pending.step(record, answers);
  EXPECT_TRUE(pending.cancel(7));
  EXPECT_FALSE(pending.cancel(7)) << "it would release a later one";
}

TEST(Pending, ACancelledRequestIsNeverAnswered) {
  server::PendingRequests pending;
  pending.add(stop(), 1);
  EXPECT_FALSE(pending.cancel(7)) << "only an engage has to be taken back";
  core::TickRecord record;
  record.life.stop_id = 1;
  server::PendingRequests::Answers answers;
  pending.step(record, answers);
  EXPECT_TRUE(answers.empty());
}

}  // namespace
}  // namespace haptic::test
