/// The loop paced by a device's samples, on virtual time.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "server/owner/loop/loop.hpp"
#include "tests/server/owner/loop/record_keeper.hpp"
#include "tests/server/support/device_rig.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::core::Duration;
using haptic::core::Fault;
using haptic::core::LifecycleState;
using haptic::core::TickRecord;
using haptic::core::TimePoint;
using haptic::hw::SampleSignal;
using haptic::server::LoopBody;
using haptic::server::LoopClock;
using haptic::server::Wake;
using haptic::test::DeviceRig;
using haptic::test::kStart;
using haptic::test::RecordKeeper;

/// Time stands still but for the waits. Samples come at the times it is given, in order.
class SampleClock final : public LoopClock {
 public:
  std::vector<TimePoint> arrivals{};
  std::function<void(TimePoint sample)> on_sample{[](TimePoint) {}};

  Wake wait_until(TimePoint deadline) noexcept override {
    now_ = std::max(now_, deadline);
    return {now_, Duration::zero(), {}};
  }
  Wake wait_for(SampleSignal& samples, TimePoint deadline) noexcept override {
    post(samples, now_);
    auto arrival = samples.wait_until({});
    if (!arrival) {
      const bool comes = next_ < arrivals.size() && arrivals[next_] <= deadline;
      now_ = std::max(now_, comes ? arrivals[next_] : deadline);
      post(samples, now_);
      arrival = samples.wait_until({});
    }
    return {now_, Duration::zero(), arrival};
  }
  [[nodiscard]] TimePoint now() const noexcept override { return now_; }

 private:
  void post(SampleSignal& samples, TimePoint until) {
    for (; next_ < arrivals.size() && arrivals[next_] <= until; ++next_) {
      on_sample(arrivals[next_]);
      samples.post(arrivals[next_]);
    }
  }
  TimePoint now_{kStart};
  std::size_t next_{0};
};

class PacedLoop : public testing::Test {
 protected:
  /// One sample per period, the first at kStart + `first`.
  void stream(Duration first, int count, Duration period = 1ms) {
    for (int i = 0; i < count; ++i) clock.arrivals.push_back(kStart + first + i * period);
  }
  void run(Duration length) {
    body.finish(kStart + length);
    rig.telemetry->add(0, &keeper);
    body.run();
    rig.telemetry->drain();
    rig.telemetry->remove(0, &keeper);
  }
  [[nodiscard]] TimePoint tick(std::size_t i) const { return keeper.records.at(i).input.now; }

  DeviceRig rig{};
  SampleClock clock{};
  RecordKeeper keeper{};
  SampleSignal samples{};
  LoopBody body{{rig.unit.get()}, rig.telemetry->bell(), 1ms, clock, &samples};
};

TEST_F(PacedLoop, TicksWhenTheSampleComes) {
  stream(900us, 100);
  run(90ms);
  ASSERT_GE(keeper.records.size(), 89u);
  for (std::size_t i = 0; i < 89; ++i) {
    EXPECT_EQ(tick(i), clock.arrivals[i]);
    EXPECT_EQ(keeper.records[i].input.loop.lateness, 0ns);
    EXPECT_EQ(keeper.records[i].input.period, 1ms);
  }
  EXPECT_EQ(body.statistics().paced_by_sample, body.statistics().ticks);
}

TEST_F(PacedLoop, SilentDeviceFaultsByTheTimer) {
  rig.tick(5);
  stream(700us, 20);
  clock.on_sample = [this](TimePoint sample) {
    rig.device->silent = sample >= kStart + 19ms;  // its last sample is never read
  };
  run(60ms);
  const auto silent = std::find_if(keeper.records.begin(), keeper.records.end(),
                                   [](const TickRecord& r) { return r.faults().any(); });
  ASSERT_NE(silent, keeper.records.end());
  EXPECT_TRUE(silent->faults().has(Fault::kDeviceSilent));
  // The silence counts from the sample at 18.7 ms, and no tick is further from the last than a
  // period and a quarter.
  const Duration allowed = rig.unit->config().device.max_silence;
  EXPECT_LE(silent->input.now, kStart + 18700us + allowed + 1250us);
  EXPECT_EQ(silent->life.state, LifecycleState::kFault);
  const auto by_sample = body.statistics().paced_by_sample;
  EXPECT_EQ(by_sample, 20u);
  EXPECT_EQ(body.statistics().ticks, 20u + 41u) << "by the timer at 20.95, 21.95 ... 60.95 ms";
  for (std::size_t i = 21; i < keeper.records.size(); ++i) {
    EXPECT_EQ(tick(i) - tick(i - 1), 1ms);
    EXPECT_EQ(keeper.records[i].input.loop.lateness, 0ns);
  }
}

TEST_F(PacedLoop, ProxyAgesWhileDeviceIsSilent) {
  rig.control();
  rig.press();
  ASSERT_EQ(rig.state(), LifecycleState::kEngaged);
  // Neither samples nor proxies from here on: gone are both promises' causes.
  rig.device->silent = true;
  run(rig.now - kStart + 200ms);
  EXPECT_EQ(rig.device->force.load(), 0.0);
  EXPECT_EQ(body.statistics().paced_by_sample, 0u);
  EXPECT_EQ(keeper.records.back().life.state, LifecycleState::kFault);
}

TEST_F(PacedLoop, HalfRatePairsKeepTheRate) {
  for (int i = 0; i < 100; ++i) {  // two samples together every 2 ms, a little early or late
    const TimePoint at = kStart + (2 * i + 1) * 1ms + (i * 7919 % 120) * 1us;
    clock.arrivals.push_back(at);
    clock.arrivals.push_back(at + 5us);
  }
  run(190ms);
  EXPECT_NEAR(static_cast<double>(body.statistics().ticks), 190.0, 2.0);
  EXPECT_EQ(body.statistics().skipped, 0u);
  for (std::size_t i = 1; i < keeper.records.size(); ++i) {
    EXPECT_GE(tick(i) - tick(i - 1), 750us);
    EXPECT_LE(tick(i) - tick(i - 1), 1250us);
  }
}

}  // namespace
