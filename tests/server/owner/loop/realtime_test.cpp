// The server's word about its real-time grant, on hosts of all kinds.
#include "server/owner/loop/realtime.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <string>

#include "haptic/core/error.hpp"
#include "tests/server/owner/loop/fake_host.hpp"

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
  try {
    static_cast<void>(apply_realtime({RealtimeMode::kRequire, 80, {}, {}}, host));
    FAIL() << "must throw";
  } catch (const haptic::core::RealtimeError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--realtime=require"));
    EXPECT_THAT(error.what(), HasSubstr("EPERM"));
  }
}

TEST(Realtime, RequireAcceptsAFullGrant) {
  FakeHost host;
  EXPECT_EQ(apply_realtime({RealtimeMode::kRequire, 80, {}, {}}, host).facts.grade, "real-time");
}

TEST(Realtime, OffAsksForNothing) {
  FakeHost host;
  const RealtimeGrant grant = apply_realtime({RealtimeMode::kOff, 80, {}, {}}, host);
  EXPECT_EQ(grant.facts.grade, "best-effort");
  EXPECT_EQ(host.fifo_calls, 0);
  EXPECT_EQ(host.locks, 0);
  EXPECT_EQ(grant.loop_late_fault, 20ms);
  EXPECT_THAT(grant.facts.explanation.str(), HasSubstr("--realtime=off"));
}

TEST(Realtime, ScenesLateFaultWins) {
  FakeHost host;
  RealtimeRequest request{.loop_late_fault = 5ms};
  const RealtimeGrant grant = apply_realtime(request, host);
  EXPECT_EQ(grant.loop_late_fault, 5ms);
  EXPECT_THAT(grant.facts.explanation.str(), HasSubstr("loop_late_fault is 5 ms (the scene's)"));
}

// MCL_FUTURE under a limit that binds would end the process at the next thread.
TEST(Realtime, NeverLocksMemoryUnderALimit) {
  FakeHost host;
  host.ipc_lock = false;
  const RealtimeGrant grant = apply_realtime({}, host);
  EXPECT_EQ(host.locks, 0);
  EXPECT_FALSE(grant.facts.memory_locked);
  EXPECT_TRUE(grant.facts.sched_fifo);
  EXPECT_EQ(grant.facts.grade, "degraded");
  EXPECT_EQ(grant.loop_late_fault, 8ms);
}

TEST(Realtime, RaisesMemoryLimitToUnlimitedHard) {
  FakeHost host;
  host.ipc_lock = false;
  host.memlock.hard = std::nullopt;
  const RealtimeGrant grant = apply_realtime({}, host);
  EXPECT_EQ(host.raises, 1);
  EXPECT_EQ(host.locks, 1);
  EXPECT_TRUE(grant.facts.memory_locked);
}

TEST(Realtime, UnlimitedMemoryNeedsNoCapability) {
  FakeHost host;
  host.ipc_lock = false;
  host.memlock = {};
  EXPECT_TRUE(apply_realtime({}, host).facts.memory_locked);
  EXPECT_EQ(host.raises, 0);
}

TEST(Realtime, ARefusedLockNamesItsErrno) {
  FakeHost host;
  host.lock_error = ENOMEM;
  EXPECT_THAT(apply_realtime({}, host).facts.explanation.str(),
              HasSubstr("memory locking refused (ENOMEM: Cannot allocate memory)"));
}

TEST(Realtime, ProcessorsThatSleepDegradeTheGrade) {
  FakeHost host;
  host.idle_error = ENOENT;
  const RealtimeGrant grant = apply_realtime({}, host);
  EXPECT_FALSE(grant.may_keep_awake);
  EXPECT_EQ(grant.facts.grade, "degraded");
  EXPECT_EQ(grant.loop_late_fault, 8ms);
  EXPECT_THAT(grant.facts.explanation.str(),
              HasSubstr("/dev/cpu_dma_latency refused (ENOENT: No such file or directory): idle "
                        "processors sleep"));
}

TEST(Realtime, TakesTheAllowedLowerPriority) {
  FakeHost host;
  host.highest_priority = 20;
  host.sys_nice = false;
  host.rtprio = {20, 20};
  const RealtimeGrant grant = apply_realtime({}, host);
  EXPECT_TRUE(grant.facts.sched_fifo);
  EXPECT_EQ(grant.facts.priority, 20);
  EXPECT_EQ(grant.facts.grade, "degraded");
  EXPECT_EQ(grant.loop_late_fault, 8ms);
  EXPECT_THAT(grant.facts.explanation.str(), HasSubstr("priority 20, not the scene's 80"));
}

TEST(Realtime, RefusalPointsToTheControlGroup) {
  FakeHost host;
  host.highest_priority = 0;
  EXPECT_THAT(apply_realtime({}, host).facts.explanation.str(),
              HasSubstr("the control group or container gives no real-time budget"));
}

TEST(Realtime, ReportsAScantRealTimeShare) {
  FakeHost host;
  host.share = 0.1;
  const RealtimeGrant grant = apply_realtime({}, host);
  EXPECT_EQ(grant.facts.grade, "degraded");
  EXPECT_THAT(grant.facts.explanation.str(), HasSubstr("sched_rt_runtime_us"));
  EXPECT_THAT(grant.facts.explanation.str(), HasSubstr("10 %"));
}

TEST(Realtime, NamesAnAbsentCpu) {
  FakeHost host;
  host.cpu_error = EINVAL;
  const RealtimeGrant grant = apply_realtime({RealtimeMode::kTry, 80, 63, {}}, host);
  EXPECT_EQ(grant.facts.cpu, -1);
  EXPECT_EQ(grant.facts.grade, "degraded");
  EXPECT_THAT(grant.facts.explanation.str(), HasSubstr("pinning to CPU 63 refused (EINVAL"));
}

}  // namespace
