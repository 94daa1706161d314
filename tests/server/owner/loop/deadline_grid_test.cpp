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

class DeadlineGrid : public testing::Test {
 protected:
  [[nodiscard]] TimePoint deadline() const { return grid.latest(); }
  LoopReport wake(TimePoint now, Duration suspended = 0ns) {
    return grid.wake(now, suspended, std::nullopt).report;
  }
  haptic::server::SampleGrid grid{kFirst, kPeriod, Duration(0)};
};

/// One wake for the first deadline; all times from there.
TEST_F(DeadlineGrid, EachWakeIsOneTick) {
  const struct {
    const char* what;
    Duration at, suspended, lateness;
    std::uint32_t skipped;
    Duration next;
  } rows[] = {
      {"early", -10us, 0ns, 0ns, 0, 1ms},
      {"punctual", 0ns, 0ns, 0ns, 0, 1ms},
      {"within the period", 300us, 0ns, 300us, 0, 1ms},
      {"at the next deadline", 1ms, 0ns, 1ms, 1, 2ms},
      {"periods later", 3700us, 0ns, 3700us, 3, 4ms},  // the deadlines at 1, 2 and 3 ms
      {"after a jump of the clock", 2h, 0ns, 2h, 7'200'000, 2h + 1ms},
      {"after a suspend", 20us, 30s, 30s + 20us, 0, 1ms},
  };
  for (const auto& row : rows) {
    SCOPED_TRACE(row.what);
    grid = haptic::server::SampleGrid(kFirst, kPeriod, Duration(0));
    const LoopReport report = wake(kFirst + row.at, row.suspended);
    EXPECT_EQ(report.lateness, row.lateness);
    EXPECT_EQ(report.skipped, row.skipped);
    EXPECT_EQ(deadline(), kFirst + row.next);
    EXPECT_EQ(wake(deadline()).lateness, 0ns) << "the next one is punctual";
  }
}

TEST_F(DeadlineGrid, OverrunCausesLatenessNotABurst) {
  static_cast<void>(wake(kFirst));
  // The tick took 2.5 ms: the wait for 1 ms returns at once.
  const LoopReport report = wake(kFirst + 2500us);
  EXPECT_EQ(report.lateness, 1500us);
  EXPECT_EQ(report.skipped, 1u);
  EXPECT_EQ(wake(kFirst + 3ms).lateness, 0ns);
}

TEST_F(DeadlineGrid, CountSaturatesAtTheLargest) {
  grid = haptic::server::SampleGrid(kFirst, 1us, Duration(0));
  EXPECT_EQ(wake(kFirst + 24h).skipped, std::numeric_limits<std::uint32_t>::max());
}

}  // namespace
