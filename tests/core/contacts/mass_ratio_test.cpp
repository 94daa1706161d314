#include "haptic/core/contacts/mass_ratio.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace haptic::core {
namespace {

/// A second of comparisons, 60 of them: x and y of each, and how far off x may be.
template <typename Compare>
MassRatio after(Compare&& compare) {
  MassRatio ratio;
  for (int n = 0; n < 60; ++n) {
    MassRatio::Seen seen;
    compare(n, seen);
    ratio.learn(seen, 1.0 / 60.0);
  }
  return ratio;
}

TEST(MassRatio, TellsTheTrueMass) {
  for (const double true_ratio : {0.5, 1.0, 2.0}) {
    const MassRatio ratio = after([&](int n, MassRatio::Seen& seen) {
      const double x = std::sin(0.1 * n);
      seen.add(0.3, x, true_ratio * x, 1e-3);
    });
    // The right one stays to the bit.
    EXPECT_NEAR(ratio.value(), true_ratio, true_ratio == 1.0 ? 0.0 : 1e-4);
  }
}

TEST(MassRatio, WithoutMotionNothingChanges) {
  MassRatio ratio;
  MassRatio::Seen moved, still;
  moved.add(1.0, 0.2, 0.1, 1e-5);
  still.add(1.0, 1e-7, -3e-7, 1e-3);  // rounding of what is in balance
  for (int n = 0; n < 600; ++n) ratio.learn(still, 1.0 / 60.0);
  EXPECT_NEAR(ratio.value(), 1.0, 1e-3);
  ratio.learn(moved, 1.0 / 60.0);
  const double learnt = ratio.value();
  EXPECT_NEAR(learnt, 0.5, 1e-3);
  for (int n = 0; n < 600; ++n) ratio.learn(still, 1.0 / 60.0);
  EXPECT_NEAR(ratio.value(), learnt, 1e-3);
}

TEST(MassRatio, AnotherMassReplacesTheFirst) {
  MassRatio ratio = after([](int, MassRatio::Seen& seen) { seen.add(1.0, 0.1, 0.2, 1e-4); });
  for (int n = 0; n < 180; ++n) {  // 7 times what is remembered: e^-7 of the others is left
    MassRatio::Seen seen;
    seen.add(1.0, 0.1, 0.05, 1e-4);
    ratio.learn(seen, 1.0 / 60.0);
  }
  EXPECT_NEAR(ratio.value(), 0.5, 0.1);
}

TEST(MassRatio, NoNumberLeadsBeyondTheBounds) {
  const double most = std::numeric_limits<double>::max();
  const double numbers[]{0.0, 1e-320, -1e-160, 1.0, -1e160, most, HUGE_VAL, std::nan("")};
  MassRatio ratio;
  for (const double x : numbers) {
    for (const double y : numbers) {
      for (const double wrong : numbers) {
        MassRatio::Seen seen;
        seen.add(1.0, x, y, wrong);
        ratio.learn(seen, 0.01);
        ASSERT_GE(ratio.value(), 0.25);
        ASSERT_LE(ratio.value(), 4.0);
      }
    }
  }
}

}  // namespace
}  // namespace haptic::core
