#include "server/owner/loop/loop.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>
#include <thread>
#include <vector>

#include "haptic/core/error.hpp"
#include "tests/server/owner/loop/fake_host.hpp"
#include "tests/server/owner/loop/record_keeper.hpp"
#include "tests/server/support/device_rig.hpp"
#include "tests/support/allocation_guard.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::core::Duration;
using haptic::core::LifecycleState;
using haptic::core::TickRecord;
using haptic::core::TimePoint;
using haptic::server::Loop;
using haptic::server::LoopBody;
using haptic::server::LoopClock;
using haptic::server::Wake;
using haptic::test::DeviceRig;
using haptic::test::kStart;
using haptic::test::RecordKeeper;

constexpr TimePoint kFirstDeadline = kStart + 1ms;
constexpr TimePoint kNever = TimePoint::max() - 1ns;

/// Time stands still but for the waits: each ends at its deadline plus what the test says.
class VirtualClock final : public LoopClock {
 public:
  std::function<Duration(int wait)> late{[](int) { return Duration::zero(); }};
  std::function<Duration(int wait)> suspended{[](int) { return Duration::zero(); }};
  std::function<void(int wait)> before{[](int) {}};

  Wake wait_until(TimePoint deadline) noexcept override {
    before(waits_);
    now_ = std::max(now_, deadline) + late(waits_);
    return {now_, suspended(waits_++)};
  }
  Wake wait_for(haptic::hw::SampleSignal& samples, TimePoint deadline) noexcept override {
    Wake wake = wait_until(deadline);
    wake.arrival = samples.wait_until({});
    return wake;
  }
  [[nodiscard]] TimePoint now() const noexcept override { return now_; }
  void set(TimePoint now) { now_ = now; }

 private:
  TimePoint now_{kStart};
  int waits_{0};
};

class VirtualLoop : public testing::Test {
 protected:
  /// Runs until the body is done, and collects the records.
  void run() {
    rig.telemetry->add(0, &keeper);
    body.run();
    rig.telemetry->drain();
    rig.telemetry->remove(0, &keeper);
  }
  DeviceRig rig{};
  VirtualClock clock{};
  RecordKeeper keeper{};
  LoopBody body{{rig.unit.get()}, rig.telemetry->bell(), 1ms, clock};
};

TEST_F(VirtualLoop, TicksOnTheGridUntilStopped) {
  body.finish(kFirstDeadline + 9ms);
  run();
  ASSERT_EQ(keeper.records.size(), 10u);
  for (std::size_t i = 0; i < keeper.records.size(); ++i) {
    EXPECT_EQ(keeper.records[i].input.now, kFirstDeadline + static_cast<int>(i) * 1ms);
    EXPECT_EQ(keeper.records[i].input.period, 1ms);
    EXPECT_EQ(keeper.records[i].input.loop.skipped, 0u);
  }
  EXPECT_EQ(body.statistics().ticks, 10u);
}

TEST_F(VirtualLoop, LateWakeIsOneLateTick) {
  clock.late = [](int wait) { return wait == 3 ? Duration(3700us) : Duration::zero(); };
  body.finish(kFirstDeadline + 9ms);
  run();
  ASSERT_EQ(keeper.records.size(), 7u);  // 10 deadlines, 3 passed over
  const TickRecord& late = keeper.records[3];
  EXPECT_EQ(late.input.now, kFirstDeadline + 3ms + 3700us);
  EXPECT_EQ(late.input.loop.lateness, 3700us);
  EXPECT_EQ(late.input.loop.skipped, 3u);
  EXPECT_EQ(keeper.records[4].input.now, kFirstDeadline + 7ms);
  EXPECT_EQ(keeper.records[4].input.loop.lateness, 0ns);
  EXPECT_EQ(body.statistics().skipped, 3u);
  EXPECT_EQ(body.statistics().lateness.max, 3700us);
}

TEST_F(VirtualLoop, SuspendIsAFault) {
  clock.suspended = [](int wait) { return wait == 5 ? Duration(30s) : Duration::zero(); };
  body.finish(kFirstDeadline + 9ms);
  run();
  ASSERT_GT(keeper.records.size(), 6u);
  EXPECT_FALSE(keeper.records[4].faults().any());
  EXPECT_TRUE(keeper.records[5].faults().has(haptic::core::Fault::kLoopLate));
  EXPECT_EQ(keeper.records[5].life.state, LifecycleState::kFault);
}

TEST_F(VirtualLoop, UnderForceReleasesFirst) {
  rig.control();
  rig.press();
  ASSERT_EQ(rig.state(), LifecycleState::kEngaged);
  const TimePoint start = rig.now;
  clock.set(start);
  clock.before = [this, start](int wait) {
    rig.now = start + wait * 1ms;
    rig.publish(0.01);
    if (wait != 3) return;
    rig.owner->begin_closing();
    body.finish(kNever);
  };
  run();
  std::set<LifecycleState> seen;
  double last_gain = 2.0;
  for (const TickRecord& record : keeper.records) {
    seen.insert(record.life.state);
    if (record.life.state == LifecycleState::kReleasing) {
      EXPECT_LE(record.life.gain, last_gain);
      last_gain = record.life.gain;
    }
  }
  EXPECT_TRUE(seen.contains(LifecycleState::kReleasing));
  EXPECT_EQ(keeper.records.back().life.state, LifecycleState::kClosing);
  EXPECT_EQ(rig.device->force.load(), 0.0);
  // fade_end - hold_end = 80 ms, and the ticks at both ends.
  EXPECT_LT(keeper.records.size(), 90u);
  EXPECT_GT(keeper.records.size(), 75u);
}

/// With force that is lost for want of samples. Every shipped scene: SceneRun; a loop that samples
/// pace: SampleSignal.NeitherSideAllocates.
TEST_F(VirtualLoop, AllocatesNothing) {
  rig.control();
  rig.press();
  clock.set(rig.now);
  body.finish(rig.now + 500ms);
  const haptic::test::AllocationGuard guard;
  body.run();
  EXPECT_EQ(guard.allocations(), 0u);
  EXPECT_EQ(guard.releases(), 0u);
  EXPECT_EQ(rig.unit->state(), LifecycleState::kArmed);
}

haptic::server::RealtimeRequest off() {
  return {.mode = haptic::server::RealtimeMode::kOff};
}

TEST(Loop, EndsWithoutEverTicking) {
  const Loop loop(off(), 1ms);
  EXPECT_EQ(loop.grant().facts.grade, "best-effort");
  EXPECT_EQ(loop.statistics().ticks, 0u);
}

TEST(Loop, RefusedGrantThrowsInTheConstructor) {
  haptic::test::FakeHost host;
  haptic::test::take_everything_away(host);
  haptic::server::RealtimeRequest request{.mode = haptic::server::RealtimeMode::kRequire};
  EXPECT_THROW(Loop(request, 1ms, host), haptic::core::RealtimeError);
}

TEST(Loop, RunsUntilEveryUnitIsClosing) {
  DeviceRig rig;
  Loop loop(off(), 1ms);
  rig.telemetry->start();
  loop.begin({rig.unit.get()}, rig.telemetry->bell());
  while (loop.statistics().ticks < 20) std::this_thread::yield();
  rig.owner->begin_closing();
  loop.finish(30s);  // returns long before that
  rig.telemetry->stop();
  EXPECT_EQ(rig.unit->state(), LifecycleState::kClosing);
  EXPECT_EQ(rig.newest().life.state, LifecycleState::kClosing);
}

}  // namespace
