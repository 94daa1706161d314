#include "server/owner/loop/sample_grid.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "tests/server/owner/loop/grid_times.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::core::Duration;
using haptic::core::TimePoint;
using haptic::server::SampleGrid;
using haptic::test::kFirst;
using haptic::test::kPeriod;

/// A sample that came at `at` woke the loop at once.
SampleGrid::Tick on_time(SampleGrid& grid, TimePoint at) {
  return grid.wake(std::max(at, grid.earliest()), 0ns, at);
}

/// None came by the timer's deadline.
SampleGrid::Tick silent(SampleGrid& grid) {
  return grid.wake(grid.latest(), 0ns, std::nullopt);
}

TEST(SampleGrid, SampleMakesATickOnTime) {
  SampleGrid grid(kFirst, kPeriod, kPeriod / 4);
  // A board whose clock is 2 % slow: the loop follows it, and its timer never has to help.
  for (int i = 0; i < 1000; ++i) {
    const TimePoint arrival = kFirst + i * 1020us;
    ASSERT_LT(arrival, grid.latest());
    const SampleGrid::Tick tick = on_time(grid, arrival);
    EXPECT_TRUE(tick.by_sample);
    EXPECT_EQ(tick.report.lateness, 0ns);
    EXPECT_EQ(tick.report.skipped, 0u);
    EXPECT_EQ(grid.earliest(), arrival + 750us);
    EXPECT_EQ(grid.latest(), arrival + 1250us);
  }
}

TEST(SampleGrid, SilentDeviceIsTickedByTimer) {
  SampleGrid grid(kFirst, kPeriod, kPeriod / 4);
  static_cast<void>(on_time(grid, kFirst + 100us));
  for (int i = 1; i <= 1000; ++i) {
    EXPECT_EQ(grid.latest(), kFirst + 100us + i * kPeriod + 250us);
    const SampleGrid::Tick tick = silent(grid);
    EXPECT_FALSE(tick.by_sample);
    EXPECT_EQ(tick.report.lateness, 0ns) << "it ticked when it said it would";
    EXPECT_EQ(tick.report.skipped, 0u);
  }
}

TEST(SampleGrid, OneLostSampleDelaysNoOther) {
  SampleGrid grid(kFirst, kPeriod, kPeriod / 4);
  static_cast<void>(on_time(grid, kFirst));
  static_cast<void>(silent(grid));
  EXPECT_LE(grid.earliest(), kFirst + 2ms);
  const SampleGrid::Tick tick = on_time(grid, kFirst + 2ms);
  EXPECT_TRUE(tick.by_sample);
  EXPECT_EQ(tick.report.lateness, 0ns);
  EXPECT_EQ(grid.latest(), kFirst + 3250us);
}

TEST(SampleGrid, FollowsAReturningDeviceInTime) {
  for (Duration phase = 0us; phase < kPeriod; phase += 10us) {
    SampleGrid grid(kFirst, kPeriod, kPeriod / 4);
    for (int i = 0; i < 20; ++i) static_cast<void>(silent(grid));
    // Its samples: the first one within the millisecond after the last of the timer's ticks.
    TimePoint sample = grid.latest() - kPeriod + phase;
    int ticks = 0;
    for (Duration behind = 1ns; behind > 0ns; ++ticks) {
      ASSERT_LT(ticks, 4) << "phase " << phase.count() << " ns";
      const TimePoint at = std::max(sample, grid.earliest());
      ASSERT_LE(at, grid.latest());
      EXPECT_TRUE(on_time(grid, sample).by_sample);
      behind = at - sample;
      sample += kPeriod;
    }
  }
}

TEST(SampleGrid, PunctualSampleNeverWaits) {
  for (const Duration patience : {kPeriod / 8, kPeriod / 4, kPeriod / 2}) {
    SampleGrid grid(kFirst, kPeriod, patience);
    static_cast<void>(on_time(grid, kFirst));
    EXPECT_EQ(grid.latest(), kFirst + kPeriod + patience);
    static_cast<void>(silent(grid));
    EXPECT_EQ(grid.earliest(), kFirst + 2 * kPeriod);
    EXPECT_EQ(on_time(grid, kFirst + 2 * kPeriod).report.lateness, 0ns);
  }
}

TEST(SampleGrid, HeapedSamplesMakeNoBurst) {
  SampleGrid grid(kFirst, kPeriod, kPeriod / 4);
  TimePoint last = kFirst;
  static_cast<void>(on_time(grid, last));
  // A board gone mad: a sample every 20 us.
  for (int i = 0; i < 1000; ++i) {
    const TimePoint at = grid.earliest();
    EXPECT_GE(at - last, 750us);
    EXPECT_TRUE(on_time(grid, last + 20us).by_sample);
    last = at;
  }
}

TEST(SampleGrid, LatenessCountsFromTheSample) {
  SampleGrid grid(kFirst, kPeriod, kPeriod / 4);
  const SampleGrid::Tick tick = grid.wake(kFirst + 300us, 0ns, kFirst - 100us);
  EXPECT_TRUE(tick.by_sample);
  EXPECT_EQ(tick.report.lateness, 400us);
  EXPECT_EQ(tick.report.skipped, 0u);
  EXPECT_EQ(grid.latest(), kFirst - 100us + 1250us)
      << "a late tick does not move the device's phase";
}

TEST(SampleGrid, WaitingSampleIsNoLateTick) {
  SampleGrid grid(kFirst, kPeriod, kPeriod / 4);
  static_cast<void>(on_time(grid, kFirst));
  const SampleGrid::Tick tick = grid.wake(kFirst + 790us, 0ns, kFirst + 200us);
  EXPECT_TRUE(tick.by_sample);
  EXPECT_EQ(tick.report.lateness, 40us);
}

TEST(SampleGrid, LateSampleIsTheTimersTick) {
  SampleGrid grid(kFirst, kPeriod, kPeriod / 4);
  const SampleGrid::Tick tick = grid.wake(kFirst + 400us, 0ns, kFirst + 350us);
  EXPECT_FALSE(tick.by_sample);
  EXPECT_EQ(tick.report.lateness, 150us) << "of kFirst + 250 us";
}

TEST(SampleGrid, LatePeriodsTickOnceAndCount) {
  SampleGrid grid(kFirst, kPeriod, kPeriod / 4);
  const SampleGrid::Tick tick = grid.wake(kFirst + 3700us, 0ns, kFirst);
  EXPECT_EQ(tick.report.lateness, 3700us);
  EXPECT_EQ(tick.report.skipped, 3u);
  EXPECT_EQ(grid.latest(), kFirst + 4250us);
  const SampleGrid::Tick of_timer = grid.wake(grid.latest() + 2100us, 0ns, std::nullopt);
  EXPECT_EQ(of_timer.report.lateness, 2100us);
  EXPECT_EQ(of_timer.report.skipped, 2u);
  EXPECT_EQ(grid.latest(), kFirst + 7250us);
}

/// Whatever comes when: one tick per due time, due times a period apart, give or take the patience,
/// and no due time forgotten. With a patience of 0 the timer alone makes the ticks.
TEST(SampleGrid, DueTimesKeepTheirDistance) {
  for (const Duration patience : {Duration(0), kPeriod / 4}) {
    SampleGrid grid(kFirst, kPeriod, patience);
    std::uint64_t random = 1;
    const auto draw = [&random](std::int64_t below) {
      random = random * 6364136223846793005u + 1442695040888963407u;
      return Duration(static_cast<std::int64_t>(random >> 33) % below);
    };
    TimePoint now = kFirst - kPeriod;
    TimePoint last_due = now;
    for (int i = 0; i < 20'000; ++i) {
      const TimePoint earliest = grid.earliest(), latest = grid.latest();
      ASSERT_TRUE(patience == 0ns ? earliest == latest : earliest < latest);
      ASSERT_LE(latest - last_due, kPeriod + patience);
      ASSERT_GE(earliest - last_due, kPeriod - patience);
      const TimePoint arrival = now + draw(2'000'000);
      const bool came = patience > 0ns && arrival <= latest;
      now = std::max(now, came ? std::max(arrival, earliest) : latest) +
            draw(i % 7 == 0 ? 4'500'000 : 90'000);
      const SampleGrid::Tick tick =
          grid.wake(now, 0ns, came ? std::optional(arrival) : std::nullopt);
      EXPECT_EQ(tick.by_sample, came);
      EXPECT_GE(tick.report.lateness, 0ns);
      last_due = now - tick.report.lateness + tick.report.skipped * kPeriod;
      ASSERT_LE(last_due, now);
      ASSERT_GT(last_due + kPeriod, now);
    }
  }
}

}  // namespace
