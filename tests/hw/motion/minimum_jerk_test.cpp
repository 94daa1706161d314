#include "hw/motion/minimum_jerk.hpp"

#include <gtest/gtest.h>

namespace haptic::hw {
namespace {

TEST(MinimumJerk, StartsAndEndsAtRest) {
  constexpr double h = 1e-4;
  EXPECT_EQ(minimum_jerk(0.0), 0.0);
  EXPECT_EQ(minimum_jerk(1.0), 1.0);
  EXPECT_NEAR(minimum_jerk(0.5), 0.5, 1e-15);
  for (const double end : {0.0, 1.0}) {
    const double before = minimum_jerk(end - h), at = minimum_jerk(end),
                 after = minimum_jerk(end + h);
    EXPECT_NEAR((after - before) / (2 * h), 0.0, 1e-6);
    EXPECT_NEAR((after - 2 * at + before) / (h * h), 0.0, 1e-2);
  }
}

TEST(MinimumJerk, ThePeakSpeedIsMinimumJerk) {
  // Flash and Hogan's own figure for the profile.
  double fastest = 0.0;
  for (double p = 0.0; p < 1.0; p += 1e-4) {
    fastest = std::max(fastest, (minimum_jerk(p + 1e-4) - minimum_jerk(p)) / 1e-4);
  }
  EXPECT_NEAR(fastest, 1.875, 1e-4);
}

}  // namespace
}  // namespace haptic::hw
