#include <gtest/gtest.h>

#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using core::DeviceState;
using core::Fault;
using core::FaultSet;
using server::DeviceEvent;
using server::Done;
using server::Outcome;
using server::Refusal;

FaultSet only(Fault fault) {
  FaultSet set;
  set.set(fault);
  return set;
}

TEST(EmergencyStop, NeedsNoSessionAndZeroesTheCommandWithinTwoTicks) {
  DeviceRig rig;
  rig.control();
  rig.press();
  ASSERT_GT(rig.device->force, 0.5);
  bool stopped = false;
  rig.sessions->emergency_stop("button", [&](const Outcome<Done>& o) { stopped = bool(o); });
  EXPECT_FALSE(stopped);  // nobody claims what the loop has not done
  rig.stream(2, 0.01);
  EXPECT_TRUE(stopped);
  EXPECT_EQ(rig.state(), DeviceState::kFault);
  EXPECT_EQ(rig.device->force, 0.0);
}

TEST(EmergencyStop, ItsEventCarriesTheReasonThatWasGiven) {
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
    EXPECT_NE(event->message.find("finger stuck"), std::string::npos);
  }
  EXPECT_TRUE(seen);
}

TEST(ClearFault, AFaultStaysUntilItIsClearedThenTheDeviceIsIdleOrArmed) {
  DeviceRig rig;
  rig.tick(3);
  rig.sessions->emergency_stop("", [](const Outcome<Done>&) {});
  rig.tick(5000);
  ASSERT_EQ(rig.state(), DeviceState::kFault);
  std::optional<FaultSet> cleared;
  rig.sessions->clear_faults({}, [&](const Outcome<FaultSet>& o) { cleared = o.value; });
  rig.tick(2);
  ASSERT_TRUE(cleared.has_value());
  EXPECT_EQ(*cleared, only(Fault::kEmergencyStop));
  EXPECT_EQ(rig.state(), DeviceState::kIdle);
}

TEST(ClearFault, IsRefusedByNameWhileTheCauseIsThere) {
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
  EXPECT_NE(refusal.message.find("DEVICE_LOST"), std::string::npos);
  EXPECT_EQ(rig.state(), DeviceState::kFault);
}

TEST(ClearFault, TwoRequestsInOneTickClearBothTheirFaults) {
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

TEST(ClearFault, OneThatWaitsItsTurnClearsNoStopThatCameMeanwhile) {
  DeviceRig rig;
  rig.tick(3);
  rig.sessions->emergency_stop("first", [](const Outcome<Done>&) {});
  rig.tick(2);
  std::string reasons;
  const auto note = [&](const Outcome<FaultSet>& o) {
    reasons += o ? "ok " : o.refusal.reason + " ";
  };
  rig.sessions->clear_faults({}, note);
  rig.sessions->clear_faults({}, note);
  rig.sessions->emergency_stop("second", [](const Outcome<Done>&) {});
  rig.tick(5);
  EXPECT_EQ(reasons, "FAULT_PERSISTS FAULT_PERSISTS ");
  EXPECT_EQ(rig.state(), DeviceState::kFault);
}

TEST(ClearFault, OfAFaultThatIsNotActiveClearsNothing) {
  DeviceRig rig;
  rig.tick(3);
  std::optional<FaultSet> cleared;
  rig.sessions->clear_faults(only(Fault::kLoopLate),
                             [&](const Outcome<FaultSet>& o) { cleared = o.value; });
  ASSERT_TRUE(cleared.has_value());
  EXPECT_FALSE(cleared->any());
}

TEST(Pending, AQuestionIsGivenUpAfterABoundedNumberOfTicks) {
  server::PendingRequests pending;
  std::string reason;
  pending.add_stop(7, [&](const Outcome<Done>& o) { reason = o.refusal.reason; });
  server::PendingRequests::Closures closures;
  const core::TickRecord silent{};
  for (int i = 0; i < server::PendingRequests::kPatience - 1; ++i) pending.step(silent, closures);
  EXPECT_TRUE(closures.empty());
  pending.step(silent, closures);
  ASSERT_EQ(closures.size(), 1U);
  closures[0]();
  EXPECT_EQ(reason, "NO_ANSWER");
}

TEST(Pending, ACancelledQuestionIsNeverAnswered) {
  server::PendingRequests pending;
  const server::Ticket ticket =
      pending.add_stop(1, [](const Outcome<Done>&) { FAIL() << "answered"; });
  EXPECT_EQ(pending.cancel(ticket), server::PendingRequests::Cancelled::kRequest);
  EXPECT_EQ(pending.cancel(ticket), server::PendingRequests::Cancelled::kNothing);
  core::TickRecord record;
  record.life.stop_id = 1;
  server::PendingRequests::Closures closures;
  pending.step(record, closures);
  EXPECT_TRUE(closures.empty());
}

TEST(EventQueue, AClientThatDoesNotReadLosesStalenessFirstAndIsToldHowMuch) {
  server::EventQueue queue;
  DeviceEvent fault;
  fault.kind = DeviceEvent::Kind::kFault;
  fault.reason = "DEVICE_LOST";
  DeviceEvent staleness;
  staleness.kind = DeviceEvent::Kind::kStaleness;
  queue.push(fault);
  for (std::size_t i = 0; i < server::EventQueue::kCapacity + 9; ++i) queue.push(staleness);
  const auto first = queue.pop();
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->reason, "DEVICE_LOST");
  EXPECT_NE(first->message.find("10 older events"), std::string::npos);
  EXPECT_EQ(queue.dropped(), 10U);
  std::size_t rest = 0;
  while (queue.pop()) ++rest;
  EXPECT_EQ(rest, server::EventQueue::kCapacity - 1);
}

}  // namespace
}  // namespace haptic::test
