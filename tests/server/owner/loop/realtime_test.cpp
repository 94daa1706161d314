// The server's word about its real-time grant, on hosts of all kinds.
#include "server/owner/loop/realtime.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <string>

#include "haptic/core/error.hpp"
#include "tests/server/owner/loop/fake_host.hpp"
#include "tests/support/message_of.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::server::apply_realtime;
using haptic::server::RealtimeGrant;
using haptic::server::RealtimeMode;
using haptic::server::RealtimeRequest;
using haptic::test::FakeHost;
using haptic::test::take_everything_away;
using testing::HasSubstr;
using testing::Not;

TEST(Realtime, FullGrantTakesShortLateFault) {
  FakeHost host;
  const RealtimeGrant grant = apply_realtime({RealtimeMode::kTry, 80, 1, {}}, host);
  EXPECT_EQ(grant.facts.grade, "real-time");
  EXPECT_EQ(grant.facts.requested, "try");
  EXPECT_TRUE(grant.facts.sched_fifo);
  EXPECT_EQ(grant.facts.priority, 80);
  EXPECT_TRUE(grant.facts.memory_locked);
  EXPECT_TRUE(grant.facts.timer_slack);
  EXPECT_EQ(grant.facts.cpu, 1);
  EXPECT_EQ(grant.loop_late_fault, 8ms);
  EXPECT_TRUE(host.stack_touched);
  EXPECT_EQ(grant.facts.explanation.str(),
            "pinned to CPU 1, SCHED_FIFO 80, memory locked, idle processors stay awake while "
            "controlled; loop_late_fault is 8 ms");
  EXPECT_TRUE(grant.may_keep_awake);
  EXPECT_FALSE(host.kept_awake);
}

TEST(Realtime, BareContainerIsDegradedAndExplains) {
  FakeHost host;
  take_everything_away(host);
  const RealtimeGrant grant = apply_realtime({}, host);
  EXPECT_EQ(grant.facts.grade, "degraded");
  EXPECT_FALSE(grant.facts.sched_fifo);
  EXPECT_EQ(grant.facts.priority, 0);
  EXPECT_FALSE(grant.facts.memory_locked);
  EXPECT_EQ(grant.loop_late_fault, 20ms);
  EXPECT_THAT(grant.facts.explanation.str(),
              HasSubstr("SCHED_FIFO refused (EPERM: Operation not permitted"));
  EXPECT_THAT(grant.facts.explanation.str(), HasSubstr("other programs may delay a tick"));
  EXPECT_THAT(grant.facts.explanation.str(), HasSubstr("RLIMIT_MEMLOCK is 8192 KB"));
  EXPECT_THAT(grant.facts.explanation.str(), HasSubstr("/dev/cpu_dma_latency refused (EACCES"));
  EXPECT_THAT(grant.facts.explanation.str(), HasSubstr("loop_late_fault is 20 ms instead of 8 ms"));
}

TEST(Realtime, RequireThrowsWithTheSameWords) {
  FakeHost host;
  take_everything_away(host);
  EXPECT_THAT(haptic::test::message_of<haptic::core::RealtimeError>(
                  [&] { return apply_realtime({RealtimeMode::kRequire}, host); }),
              testing::AllOf(HasSubstr("--realtime=require"), HasSubstr("EPERM")));
}

struct Expected {
  const char* grade;
  haptic::core::Duration loop_late_fault;
  bool sched_fifo, memory_locked;
  const char* says;
};

/// The grant of a host that `spoil` has taken something away from.
void expect_grant(const Expected& expected, const RealtimeRequest& request,
                  void (*spoil)(FakeHost& host)) {
  SCOPED_TRACE(expected.says);
  FakeHost host;
  spoil(host);
  const RealtimeGrant grant = apply_realtime(request, host);
  EXPECT_EQ(grant.facts.grade, expected.grade);
  EXPECT_EQ(grant.facts.sched_fifo, expected.sched_fifo);
  EXPECT_EQ(grant.facts.memory_locked, expected.memory_locked);
  EXPECT_EQ(grant.loop_late_fault, expected.loop_late_fault);
  EXPECT_THAT(grant.facts.explanation.str(), HasSubstr(expected.says));
  EXPECT_EQ(host.fifo_calls > 0, request.mode != RealtimeMode::kOff);
  // MCL_FUTURE under a limit that binds would end the process at the next thread.
  EXPECT_EQ(host.locks > 0, expected.memory_locked || host.lock_error != 0);
}

TEST(Realtime, RequestsAreObeyed) {
  const auto whole = [](FakeHost&) {};
  expect_grant({"best-effort", 20ms, false, false, "--realtime=off"}, {RealtimeMode::kOff}, whole);
  expect_grant({"real-time", 8ms, true, true, "memory locked"}, {RealtimeMode::kRequire}, whole);
  expect_grant({"real-time", 5ms, true, true, "loop_late_fault is 5 ms (the scene's)"},
               {.loop_late_fault = 5ms}, whole);
}

TEST(Realtime, MemoryIsLockedWithoutALimit) {
  expect_grant({"degraded", 8ms, true, false, "RLIMIT_MEMLOCK is 8192 KB"}, {},
               [](FakeHost& host) { host.ipc_lock = false; });
  expect_grant({"real-time", 8ms, true, true, "memory locked"}, {}, [](FakeHost& host) {
    host.ipc_lock = false;
    host.memlock = {};
  });
  expect_grant({"real-time", 8ms, true, true, "memory locked"}, {}, [](FakeHost& host) {
    host.ipc_lock = false;
    host.memlock.hard = std::nullopt;  // the soft one is raised to it
  });
  expect_grant(
      {"degraded", 8ms, true, false, "memory locking refused (ENOMEM: Cannot allocate memory)"}, {},
      [](FakeHost& host) { host.lock_error = ENOMEM; });
}

TEST(Realtime, WhatIsMissingDegradesTheGrade) {
  expect_grant({"degraded", 8ms, true, true,
                "/dev/cpu_dma_latency refused (ENOENT: No such file or directory): idle "
                "processors sleep"},
               {}, [](FakeHost& host) { host.idle_error = ENOENT; });
  expect_grant({"degraded", 8ms, true, true, "priority 20, not the scene's 80"}, {},
               [](FakeHost& host) {
                 host.highest_priority = 20;
                 host.sys_nice = false;
                 host.rtprio = {20, 20};
               });
  expect_grant(
      {"degraded", 20ms, false, true, "the control group or container gives no real-time budget"},
      {}, [](FakeHost& host) { host.highest_priority = 0; });
  expect_grant({"degraded", 8ms, true, true, "10 %"}, {}, [](FakeHost& host) { host.share = 0.1; });
  expect_grant({"degraded", 8ms, true, true, "pinning to CPU 63 refused (EINVAL"},
               {RealtimeMode::kTry, 80, 63, {}}, [](FakeHost& host) { host.cpu_error = EINVAL; });
}

}  // namespace
