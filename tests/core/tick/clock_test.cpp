#include "core/src/tick/clock.hpp"

#include <gtest/gtest.h>

namespace haptic::core {
namespace {

using std::chrono::milliseconds;

Clock clock_of_the_defaults() {
  return {milliseconds(20), LateBucket::kFull};
}

TickInput at(int ms, std::uint32_t skipped = 0, int lateness_ms = 0) {
  TickInput in;
  in.now = TimePoint(milliseconds(ms));
  in.loop = {milliseconds(lateness_ms), skipped};
  return in;
}

TEST(Clock, CountsTicksAndTimeBetweenThem) {
  Clock clock = clock_of_the_defaults();
  const Beat first = clock.step(at(1000), true);
  EXPECT_EQ(first.tick, 1u);
  EXPECT_EQ(first.dt, milliseconds(1)) << "the period: there is no tick before";
  const Beat second = clock.step(at(1003), true);
  EXPECT_EQ(second.tick, 2u);
  EXPECT_EQ(second.dt, milliseconds(3));
  EXPECT_EQ(clock.step(at(1002), true).dt, Duration::zero()) << "time never runs back";
}

TEST(Clock, OneLateWakeIsAFault) {
  Clock clock = clock_of_the_defaults();
  EXPECT_FALSE(clock.step(at(1, 0, 20), true).faults.any());
  EXPECT_TRUE(clock.step(at(2, 0, 21), true).faults.has(Fault::kLoopLate));
  EXPECT_FALSE(clock.step(at(3), true).faults.any()) << "of its tick only";
}

/// 5 per deadline passed over, full at 100.
TEST(Clock, TwentySkippedTicksAreAFault) {
  Clock clock = clock_of_the_defaults();
  for (int i = 1; i < 20; ++i) EXPECT_FALSE(clock.step(at(i, 1), true).faults.any()) << i;
  EXPECT_TRUE(clock.step(at(20, 1), true).faults.has(Fault::kLateBucketFull));
}

TEST(Clock, NothingIsLateBeforeFirstSample) {
  Clock clock = clock_of_the_defaults();
  EXPECT_FALSE(clock.step(at(1, 1000, 500), false).faults.any());
}

}  // namespace
}  // namespace haptic::core
