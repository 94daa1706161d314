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

/// 5 per deadline passed over, 1 less for 20 on time, full at 100.
TEST(Clock, SkippedTicksAddUp) {
  Clock clock = clock_of_the_defaults();
  int now = 0;
  const auto faults_after = [&](int ticks, std::uint32_t skipped) {
    bool any = false;
    for (int i = 0; i < ticks; ++i) any = clock.step(at(++now, skipped), true).faults.any();
    return any;
  };
  EXPECT_FALSE(faults_after(19, 1)) << "95";
  EXPECT_FALSE(faults_after(40, 0)) << "93";
  EXPECT_FALSE(faults_after(1, 1)) << "98";
  EXPECT_TRUE(faults_after(1, 1));
  EXPECT_TRUE(clock_of_the_defaults().step(at(1, 20), true).faults.has(Fault::kLateBucketFull));
}

TEST(Clock, NothingIsLateBeforeFirstSample) {
  Clock clock = clock_of_the_defaults();
  EXPECT_FALSE(clock.step(at(1, 1000, 500), false).faults.any());
}

}  // namespace
}  // namespace haptic::core
