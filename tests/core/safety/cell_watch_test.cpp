// Readings that a load cell may give before it is doubted (core/METHOD.md#a-load-cell-that-lies).
// Expected values from the balance of forces on a rod: m dv/dt = drive - D v - reading - friction.
#include "haptic/core/safety/cell_watch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace haptic::core {
namespace {

constexpr double kTick = 1e-3;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const CellRatings kRatings{
    .range = 50.0, .rate = 5000.0, .swing = 5.0, .friction = 10.0, .damping = 3000.0};

class CellWatchTest : public testing::Test {
 protected:
  FaultSet step() { return watch.step(view); }
  /// Ticks until a doubt; `at_most` + 1: none.
  template <typename Change>
  int until(Fault doubt, int at_most, Change&& change) {
    for (int i = 1; i <= at_most; ++i) {
      change(i);
      const FaultSet doubts = step();
      if (doubts.has(doubt)) return i;
      EXPECT_FALSE(doubts.any()) << doubts.bits();
    }
    return at_most + 1;
  }
  CellWatch watch{kRatings};
  CellView view{.fresh = true, .interval = kTick, .driven = true, .dt = kTick};
};

TEST_F(CellWatchTest, DoubtsAReadingBeyondItsRange) {
  for (const bool driven : {true, false}) {
    for (const double reading : {50.1, -60.0, kNan, std::numeric_limits<double>::infinity()}) {
      CellWatch fresh(kRatings);
      view.driven = driven;
      view.reading = reading;
      EXPECT_TRUE(fresh.step(view).has(Fault::kForceOutOfRange)) << reading;
      view.reading = view.command = std::copysign(50.0, -1.0);
      EXPECT_FALSE(CellWatch(kRatings).step(view).any()) << "the very end";
    }
  }
}

TEST_F(CellWatchTest, DoubtsAChangeFasterThanRated) {
  EXPECT_FALSE(step().any()) << "the first reading changes nothing";
  view.reading = 5.0;  // 5000 N/s
  EXPECT_FALSE(step().any());
  view.reading = 10.1;
  EXPECT_TRUE(step().has(Fault::kForceTooFast));
  view.reading = 20.0;
  view.interval = 2.0 * kTick;  // one sample was lost
  EXPECT_FALSE(step().has(Fault::kForceTooFast));
  view.fresh = false;
  view.reading = 40.0;  // no new one: nothing has changed
  EXPECT_FALSE(step().has(Fault::kForceTooFast));
}

TEST_F(CellWatchTest, AForceMayVanishAtOnce) {
  for (const double sign : {1.0, -1.0}) {
    watch = CellWatch(kRatings);
    view.reading = sign * 30.0;
    view.command = 0.9 * view.reading;
    EXPECT_FALSE(step().any());
    view.reading = -sign * 5.0;  // to 0, and 5000 N/s beyond
    EXPECT_FALSE(step().any());
    watch = CellWatch(kRatings);
    view.reading = sign * 30.0;
    EXPECT_FALSE(step().any());
    view.reading = -sign * 5.1;
    EXPECT_TRUE(step().has(Fault::kForceTooFast));
  }
}

TEST_F(CellWatchTest, AnIdleDriveIsLeftAlone) {
  view.driven = false;
  for (int i = 0; i < 1000; ++i) {
    view.reading = i % 2 == 0 ? 45.0 : -45.0;
    ASSERT_FALSE(step().any()) << "put down hard, leaned on, disconnected";
  }
}

TEST_F(CellWatchTest, EqualReadingsWhileTheDriveSwings) {
  const int found = until(Fault::kForceStuck, 300, [&](int i) { view.command = 0.1 * i; });
  // Beyond 5 N in the 51st tick after the first, which is the first of 50 readings.
  EXPECT_NEAR(found, 51 + CellWatch::kSame, 1);
  view.reading = 0.003;  // one quantum
  EXPECT_FALSE(step().any());
}

TEST_F(CellWatchTest, EqualReadingsBehindTheLink) {
  for (int i = 0; i < 1000; ++i) ASSERT_FALSE(step().any()) << "at rest, without noise";
  view.command = 9.0;  // and the cell answers 10 ms later
  for (int i = 0; i < 10; ++i) ASSERT_FALSE(step().any());
  view.reading = 0.1;
  EXPECT_FALSE(step().any());
}

TEST_F(CellWatchTest, MissingReadingsAreNotEqualOnes) {
  view.command = 9.0;
  EXPECT_FALSE(step().any());
  for (int i = 0; i < 200; ++i) {
    view.fresh = i % 10 == 0;
    ASSERT_FALSE(step().any()) << "20 readings in 200 ticks";
  }
}

TEST_F(CellWatchTest, LastingExcessBeyondFrictionIsDoubted) {
  // The average of a step r reaches F after T ln(r / (r - F)).
  view.command = 25.0;
  view.reading = 5.0;
  const int found = until(Fault::kForceDisagrees, 500, [&](int i) { view.reading += 1e-9 * i; });
  EXPECT_NEAR(found, 1e3 * CellWatch::kTime * std::log(20.0 / (20.0 - 10.0)), 2.0);
}

TEST_F(CellWatchTest, FrictionHoldsEitherWay) {
  for (const double sign : {1.0, -1.0}) {
    watch = CellWatch(kRatings);
    for (int i = 0; i < 2000; ++i) {
      view.command = sign * 20.0;
      view.reading = sign * 10.1 + 1e-6 * (i % 2);
      ASSERT_FALSE(step().any()) << i;
    }
  }
}

TEST_F(CellWatchTest, AMovingDriveBrakesItself) {
  // Free, at 10 mm/s: the drive gives D v + friction, the cell feels nothing.
  for (int i = 0; i < 4000; ++i) {
    view.command = std::min(0.1 * i, 3000.0 * 0.01 + 9.9);
    view.q += i < 400 ? 1e-5 * i / 400.0 : 1e-5;
    view.reading = 0.01 * (i % 2);
    ASSERT_FALSE(step().any()) << i;
  }
  // It stands, and the drive goes on: after the average has forgotten the motion.
  EXPECT_LE(until(Fault::kForceDisagrees, 500, [&](int i) { view.reading = 0.01 * (i % 2); }), 200);
}

TEST_F(CellWatchTest, MotionAgainstTheForceIsDoubted) {
  view.command = 15.0;  // outwards, beyond friction, and it goes inwards
  const int found = until(Fault::kForceDisagrees, 500, [&](int i) {
    view.q -= 1e-5;
    view.reading = 0.01 * (i % 2);
  });
  EXPECT_LE(found, 200);
}

TEST_F(CellWatchTest, AnEndStopTakesForceUnfelt) {
  view.at_upper = true;
  for (int i = 0; i < 1000; ++i) {
    view.command = std::min(0.1 * i, 40.0);
    view.reading = 0.01 * (i % 2);
    ASSERT_FALSE(step().any());
  }
  view.at_upper = false;
  view.at_lower = true;
  EXPECT_TRUE(step().has(Fault::kForceDisagrees)) << "the other end takes no push outwards";
}

TEST_F(CellWatchTest, NonFiniteNumbersAreDoubted) {
  view.command = kNan;
  EXPECT_TRUE(step().has(Fault::kForceDisagrees));
  view.command = 0.0;
  view.driven = false;
  EXPECT_FALSE(step().any());
  view.driven = true;
  EXPECT_FALSE(step().any()) << "off and on: nothing of it is left";
}

TEST_F(CellWatchTest, UnratedMeansUnwatched) {
  watch = CellWatch({});
  for (int i = 0; i < 1000; ++i) {
    view.command = 1000.0;
    view.reading = i % 2 == 0 ? 1e6 : -1e6;
    ASSERT_FALSE(step().any());
  }
}

TEST(CellRatings, RefusesWhatIsNoRating) {
  EXPECT_EQ(check(CellRatings{}), nullptr);
  EXPECT_EQ(check(kRatings), nullptr);
  const auto says = [](CellRatings ratings) { return std::string(check(ratings)); };
  EXPECT_EQ(says({.range = 0.0}), "range must be > 0");
  EXPECT_EQ(says({.rate = -1.0}), "rate must be > 0");
  EXPECT_EQ(says({.swing = kNan}), "swing must be > 0");
  EXPECT_EQ(says({.friction = 0.0}), "friction must be > 0");
  EXPECT_EQ(says({.damping = -1.0}), "damping must be >= 0");
}

}  // namespace
}  // namespace haptic::core
