/// The grid of a loop that the timer alone paces.

#include <gtest/gtest.h>

#include <limits>

#include "server/owner/loop/sample_grid.hpp"
#include "tests/server/owner/loop/grid_times.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::core::Duration;
using haptic::core::LoopReport;
using haptic::core::TimePoint;
using haptic::test::kFirst;
using haptic::test::kPeriod;

class DeadlineGrid {
 public:
  DeadlineGrid(TimePoint first, Duration period) : grid_(first, period, Duration(0)) {}
  [[nodiscard]] TimePoint deadline() const { return grid_.latest(); }
  LoopReport wake(TimePoint now, Duration suspended) {
    return grid_.wake(now, suspended, std::nullopt).report;
  }

 private:
  haptic::server::SampleGrid grid_;
};

TEST(DeadlineGrid, PunctualIsNeitherLateNorSkipped) {
  DeadlineGrid grid(kFirst, kPeriod);
  for (int i = 0; i < 5; ++i) {
    const LoopReport report = grid.wake(grid.deadline(), 0ns);
    EXPECT_EQ(report.lateness, 0ns);
    EXPECT_EQ(report.skipped, 0u);
    EXPECT_EQ(grid.deadline(), kFirst + (i + 1) * kPeriod);
  }
}

TEST(DeadlineGrid, PartOfAPeriodSkipsNothing) {
  DeadlineGrid grid(kFirst, kPeriod);
  const LoopReport report = grid.wake(kFirst + 300us, 0ns);
  EXPECT_EQ(report.lateness, 300us);
  EXPECT_EQ(report.skipped, 0u);
  EXPECT_EQ(grid.deadline(), kFirst + 1ms);
}

TEST(DeadlineGrid, LatePeriodsTickOnceAndCount) {
  DeadlineGrid grid(kFirst, kPeriod);
  const LoopReport report = grid.wake(kFirst + 3700us, 0ns);
  EXPECT_EQ(report.lateness, 3700us);
  EXPECT_EQ(report.skipped, 3u);  // the deadlines at 1, 2 and 3 ms
  EXPECT_EQ(grid.deadline(), kFirst + 4ms);
}

TEST(DeadlineGrid, WakeAtTheNextDeadlineSkips) {
  DeadlineGrid grid(kFirst, kPeriod);
  EXPECT_EQ(grid.wake(kFirst + 1ms, 0ns).skipped, 1u);
  EXPECT_EQ(grid.deadline(), kFirst + 2ms);
}

TEST(DeadlineGrid, OverrunCausesLatenessNotABurst) {
  DeadlineGrid grid(kFirst, kPeriod);
  static_cast<void>(grid.wake(kFirst, 0ns));
  // The tick took 2.5 ms: the wait for 1 ms returns at once.
  const LoopReport report = grid.wake(kFirst + 2500us, 0ns);
  EXPECT_EQ(report.lateness, 1500us);
  EXPECT_EQ(report.skipped, 1u);
  EXPECT_EQ(grid.wake(kFirst + 3ms, 0ns).lateness, 0ns);
}

TEST(DeadlineGrid, EveryDeadlineIsTickedOrSkipped) {
  DeadlineGrid grid(kFirst, kPeriod);
  std::int64_t ticked = 0;
  std::int64_t skipped = 0;
  std::uint64_t random = 1;
  TimePoint now = kFirst;
  while (ticked < 10'000) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    const Duration late(static_cast<std::int64_t>((random >> 33) % 4'500'000));
    now = std::max(now, grid.deadline()) + late;
    skipped += grid.wake(now, 0ns).skipped;
    ++ticked;
    ASSERT_GT(grid.deadline(), now);
    ASSERT_LE(grid.deadline() - now, kPeriod);
  }
  EXPECT_EQ(grid.deadline(), kFirst + (ticked + skipped) * kPeriod);
  EXPECT_GT(skipped, 0);
}

TEST(DeadlineGrid, SuspendCountsAsLateness) {
  DeadlineGrid grid(kFirst, kPeriod);
  const LoopReport report = grid.wake(kFirst + 20us, 30s);
  EXPECT_EQ(report.lateness, 30s + 20us);
  EXPECT_EQ(report.skipped, 0u);
  EXPECT_EQ(grid.deadline(), kFirst + 1ms);
}

TEST(DeadlineGrid, ClockJumpGivesOneLateTick) {
  DeadlineGrid grid(kFirst, kPeriod);
  const LoopReport report = grid.wake(kFirst + 2h, 0ns);
  EXPECT_EQ(report.lateness, 2h);
  EXPECT_EQ(report.skipped, 7'200'000u);
  EXPECT_EQ(grid.wake(grid.deadline(), 0ns).lateness, 0ns);
}

TEST(DeadlineGrid, CountSaturatesAtTheLargest) {
  DeadlineGrid grid(kFirst, 1us);
  EXPECT_EQ(grid.wake(kFirst + 24h, 0ns).skipped, std::numeric_limits<std::uint32_t>::max());
}

TEST(DeadlineGrid, EarlyWakeIsNotLate) {
  DeadlineGrid grid(kFirst, kPeriod);
  const LoopReport report = grid.wake(kFirst - 10us, 0ns);
  EXPECT_EQ(report.lateness, 0ns);
  EXPECT_EQ(report.skipped, 0u);
  EXPECT_EQ(grid.deadline(), kFirst + 1ms);
}

}  // namespace
