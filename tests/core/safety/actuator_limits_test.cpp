#include "haptic/core/safety/actuator_limits.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "haptic/core/safety/limits.hpp"

namespace haptic::core {
namespace {

using std::chrono::milliseconds;
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kForce = 10.0;

struct RangeCase {
  const char* what;
  double power, rate_limit, rate;
  double lower, upper;
  Limiter by;
};

// 2 W at 0.4 m/s are 5 N; of a rate limit of 0.5 m/s the last fifth begins at 0.4 m/s.
const RangeCase kRangeCases[] = {
    {"at rest nothing limits", 2.0, 0.5, 0.0, -kInfinite, kInfinite, Limiter::kSaturation},
    {"slow: more power is allowed than there is force", 2.0, kInfinite, 0.1, -kInfinite, 20.0,
     Limiter::kPower},
    {"power, outwards", 2.0, kInfinite, 0.4, -kInfinite, 5.0, Limiter::kPower},
    {"power, inwards", 2.0, kInfinite, -0.4, -5.0, kInfinite, Limiter::kPower},
    {"rate: full force below four fifths", kInfinite, 0.5, 0.39, -kInfinite, kInfinite,
     Limiter::kSaturation},
    {"rate: half of it in the middle", kInfinite, 0.5, 0.45, -kInfinite, 5.0, Limiter::kRate},
    {"rate: nothing at the limit", kInfinite, 0.5, 0.5, -kInfinite, 0.0, Limiter::kRate},
    {"rate: nothing beyond", kInfinite, 0.5, 3.0, -kInfinite, 0.0, Limiter::kRate},
    {"rate, inwards", kInfinite, 0.5, -0.45, -5.0, kInfinite, Limiter::kRate},
    {"the narrower of both: power", 1.8, 0.5, 0.45, -kInfinite, 4.0, Limiter::kPower},
    {"the narrower of both: rate", 2.5, 0.5, 0.45, -kInfinite, 5.0, Limiter::kRate},
    {"a rate nobody knows", 2.0, 0.5, std::nan(""), -kInfinite, kInfinite, Limiter::kSaturation},
};

TEST(ActuatorLimits, TheRangeOfAMovingActuator) {
  for (const RangeCase& c : kRangeCases) {
    ActuatorRatings ratings;
    ratings.power = c.power;
    ratings.rate = c.rate_limit;
    const ForceRange range = moving_range(ratings, c.rate, kForce);
    const auto expect = [&](double got, double wanted, Limiter by) {
      if (std::isinf(wanted)) {
        EXPECT_EQ(got, wanted) << c.what;
      } else {
        EXPECT_NEAR(got, wanted, 1e-12) << c.what;
        EXPECT_EQ(by, c.by) << c.what;
      }
    };
    expect(range.lower, c.lower, range.lower_by);
    expect(range.upper, c.upper, range.upper_by);
  }
}

TEST(ActuatorLimits, BrakingIsNeverTakenAway) {
  ActuatorRatings ratings;
  ratings.power = 0.1;
  ratings.rate = 0.2;
  for (double rate = -1.0; rate <= 1.0; rate += 0.05) {
    const ForceRange range = moving_range(ratings, rate, kForce);
    if (rate > 0.0) {
      EXPECT_EQ(range.lower, -kInfinite) << rate;
    }
    if (rate < 0.0) {
      EXPECT_EQ(range.upper, kInfinite) << rate;
    }
    EXPECT_LE(range.lower, 0.0);
    EXPECT_GE(range.upper, 0.0);
  }
}

TEST(ActuatorLimits, SlewLimitNeverOverridesRatedPower) {
  ForceLimiter limiter;
  LimiterSet active;
  const double slew = 100.0;
  for (int i = 0; i < 200; ++i) limiter.step(8.0, 0.0, 1.0, kForce, slew, milliseconds(1), active);
  ForceRange range;
  range.upper = 2.0;
  range.upper_by = Limiter::kPower;
  active = {};
  const LimitedForce cut =
      limiter.step(8.0, 0.0, 1.0, kForce, slew, milliseconds(1), active, range);
  EXPECT_EQ(cut.total, 2.0);
  EXPECT_TRUE(active.has(Limiter::kPower));
  active = {};
  const LimitedForce back = limiter.step(8.0, 0.0, 1.0, kForce, slew, milliseconds(1), active);
  EXPECT_NEAR(back.total, 2.0 + slew * 1e-3, 1e-12) << "and returns no faster than its slew limit";
}

TEST(ActuatorLimits, ZeroGainLeavesNoElasticForce) {
  ForceLimiter limiter;
  LimiterSet active;
  for (int i = 0; i < 100; ++i) limiter.step(8.0, 3.0, 1.0, kForce, 1e3, milliseconds(1), active);
  ForceRange range;
  range.upper = 1.0;
  range.upper_by = Limiter::kRate;
  const LimitedForce held =
      limiter.step(0.0, 3.0, 0.0, kForce, 1e3, milliseconds(1), active, range);
  EXPECT_EQ(held.total, held.damping);
  EXPECT_LE(held.total, 1.0);
}

TEST(ActuatorLimits, NamesForbiddenRatings) {
  ActuatorRatings ratings;
  EXPECT_EQ(check(ratings), nullptr);
  EXPECT_FALSE(ratings.any());
  ratings.power = 0.0;
  EXPECT_STREQ(check(ratings), "power must be > 0");
  ratings.power = 1.0;
  EXPECT_TRUE(ratings.any());
  ratings.rate = std::nan("");
  EXPECT_STREQ(check(ratings), "rate must be > 0");
  ratings.rate = 1.0;
  ratings.thermal = ThermalParameters{};
  EXPECT_EQ(check(ratings), nullptr);
  ratings.thermal->limit_c = 10.0;
  EXPECT_NE(check(ratings), nullptr);
}

}  // namespace
}  // namespace haptic::core
