#include "haptic/wire/link_statistics.hpp"

#include <gtest/gtest.h>

namespace haptic::wire {
namespace {

using namespace std::chrono_literals;

TimePoint at(Duration time) {
  return TimePoint(time);
}

TEST(LinkStatistics, CountsLossAndReorderingByNumbers) {
  struct Step {
    std::uint64_t number, received, lost, reordered;
  };
  const Step steps[] = {{1, 1, 0, 0}, {2, 2, 0, 0}, {5, 3, 2, 0},
                        {3, 4, 1, 1}, {6, 5, 1, 1}, {4, 6, 0, 2}};
  LinkStatistics link;
  for (const Step& step : steps) {
    link.accepted(step.number, 100, {});
    EXPECT_EQ(link.counters().received, step.received) << step.number;
    EXPECT_EQ(link.counters().lost, step.lost) << step.number;
    EXPECT_EQ(link.counters().reordered, step.reordered) << step.number;
  }
  EXPECT_EQ(link.counters().bytes, 600U);
}

TEST(LinkStatistics, NewNumbersKeepTheTotals) {
  LinkStatistics link;
  link.accepted(3, 1, {});
  link.renumber();
  link.accepted(2, 1, {});
  EXPECT_EQ(link.counters().lost, 3U);
  EXPECT_EQ(link.counters().received, 2U);
  EXPECT_EQ(link.packets(), 1U);
  EXPECT_EQ(link.newest(), 2U);
}

TEST(LinkStatistics, RejectionsAreCountedByReason) {
  LinkStatistics link;
  for (int i = 0; i < 3; ++i) link.rejected(Rejection::kTag);
  link.rejected(Rejection::kDuplicate);
  link.rejected(Rejection::kTooOld);
  EXPECT_EQ(link.counters().rejections(Rejection::kTag), 3U);
  EXPECT_EQ(link.counters().duplicate(), 1U);
  EXPECT_EQ(link.counters().late(), 1U);
  EXPECT_EQ(link.counters().received, 0U);
}

TEST(LinkStatistics, LongestGapLiesBetweenArrivals) {
  LinkStatistics link;
  link.accepted(1, 1, at(10s));
  EXPECT_EQ(link.counters().longest_gap, 0ms);
  link.accepted(2, 1, at(10s + 70ms));
  link.accepted(3, 1, at(10s + 80ms));
  EXPECT_EQ(link.counters().longest_gap, 70ms);
}

TEST(LinkStatistics, SteadyLinkHasZeroJitter) {
  LinkStatistics link;
  for (int i = 0; i < 100; ++i) link.timed(5h + i * 1ms, at(i * 1ms));
  EXPECT_EQ(link.counters().jitter, 0ns);
}

TEST(LinkStatistics, JitterTendsToMeanTransitDifference) {
  LinkStatistics link;
  for (int i = 0; i < 500; ++i) link.timed(i * 10ms, at(i * 10ms + (i % 2) * 4ms));
  EXPECT_NEAR(static_cast<double>(link.counters().jitter.count()), 4e6, 1e3);
}

TEST(RoundTrip, FollowsRfc6298) {
  RoundTrip rtt;
  EXPECT_FALSE(rtt.known());
  rtt.add(80ms);
  EXPECT_EQ(rtt.smoothed(), 80ms);
  EXPECT_EQ(rtt.variation(), 40ms);
  rtt.add(40ms);
  EXPECT_EQ(rtt.variation(), 40ms);  // 3/4 of 40 and 1/4 of |80 - 40|
  EXPECT_EQ(rtt.smoothed(), 75ms);   // 7/8 of 80 and 1/8 of 40
  EXPECT_EQ(rtt.least(), 40ms);
}

TEST(LossReport, SaysNothingBeforeASecond) {
  LossReport loss;
  for (int ms = 0; ms < 1000; ms += 10) {
    loss.add(static_cast<std::uint64_t>(ms), static_cast<std::uint64_t>(2 * ms), at(ms * 1ms));
    ASSERT_FALSE(loss.share()) << ms;
  }
  loss.add(1000, 2000, at(1s));
  ASSERT_TRUE(loss.share());
  EXPECT_NEAR(*loss.share(), 0.5, 1e-12);
}

TEST(LossReport, ForgetsOldPackets) {
  LossReport loss;
  std::uint64_t came = 0;
  for (int ms = 0; ms <= 4000; ms += 10) {
    came += ms < 2000 ? 1 : 10;  // nine of ten lost, then none
    loss.add(came, static_cast<std::uint64_t>(ms), at(ms * 1ms));
  }
  EXPECT_NEAR(loss.share().value_or(1.0), 0.0, 1e-12);
}

TEST(LossReport, PassesOverReportsOutOfOrder) {
  LossReport ordered, shuffled;
  for (int i = 0; i <= 200; ++i) {
    const auto n = static_cast<std::uint64_t>(i) * 10;
    ordered.add(n / 2, n, at(i * 10ms));
    shuffled.add(n / 2, n, at(i * 10ms));
    if (i > 2) shuffled.add((n - 20) / 2, n - 20, at(i * 10ms));
  }
  EXPECT_EQ(ordered.share(), shuffled.share());
}

TEST(LossReport, FewPacketsGiveNoShare) {
  LossReport loss;
  for (int i = 0; i <= 30; ++i) {
    loss.add(0, static_cast<std::uint64_t>(i / 5), at(i * 100ms));
  }
  EXPECT_FALSE(loss.share());
}

}  // namespace
}  // namespace haptic::wire
