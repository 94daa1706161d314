#include "hw/simulated/substeps.hpp"

#include <gtest/gtest.h>

namespace haptic::hw {
namespace {

using namespace std::chrono_literals;

TEST(Substeps, StepsAddUpToTheClock) {
  for (const core::Duration period : {core::Duration(1ms), core::Duration(2ms),
                                      core::Duration(333us), core::Duration(1234567ns)}) {
    Substeps substeps;
    core::Duration t = 0s;
    std::int64_t steps = substeps.advance(core::TimePoint(7s));
    for (int i = 0; i < 1000; ++i) {
      t += period;
      steps += substeps.advance(core::TimePoint(7s) + t);
      ASSERT_EQ(steps * Substeps::kStep + substeps.rest(), t);
      ASSERT_LT(substeps.rest(), Substeps::kStep);
    }
  }
}

TEST(Substeps, AJumpSimulatesItsFirstTenth) {
  Substeps substeps;
  EXPECT_EQ(substeps.advance(core::TimePoint(0s)), 0);
  EXPECT_EQ(substeps.advance(core::TimePoint(24h)), 1000);
  EXPECT_EQ(substeps.advance(core::TimePoint(24h + 1ms)), 10);
}

TEST(Substeps, ABackwardClockMakesNoSteps) {
  Substeps substeps;
  EXPECT_EQ(substeps.advance(core::TimePoint(10s)), 0);
  EXPECT_EQ(substeps.advance(core::TimePoint(9s)), 0);
  EXPECT_EQ(substeps.advance(core::TimePoint(10s)), 0);
  EXPECT_EQ(substeps.advance(core::TimePoint(10s + 1ms)), 10);
}

}  // namespace
}  // namespace haptic::hw
