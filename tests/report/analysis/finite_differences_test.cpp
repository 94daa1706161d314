#include "tests/report/analysis/finite_differences.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace haptic::core {
namespace {

/// Steps dq = 1, 1, -1, 0.01, 0 with dtau = -2, +1, +3, +1, +5: rms = sqrt(3.0001/5) = 0.7746.
constexpr std::array<double, 6> kQ{0, 1, 2, 1, 1.01, 1.01};
constexpr std::array<double, 6> kTau{0, -2, -1, 2, 3, 8};

TEST(FiniteDifferences, SkipsAndCountsSmallSteps) {
  const FiniteDifferences fd = finite_differences(kQ, kTau);
  EXPECT_EQ(fd.steps, 5);
  EXPECT_EQ(fd.kept, 3);                                    // the unit steps
  EXPECT_NEAR(fd.nonpassive_pct, 100.0 / 3, 1e-12);         // the second alone
  EXPECT_NEAR(fd.excluded_pct, 40.0, 1e-12);                // two of five
  EXPECT_NEAR(fd.all_nonpassive_pct, 50.0, 1e-12);          // second and fourth of four that move
  EXPECT_NEAR(fd.energy_weighted_pct, 101.0 / 6.01, 1e-9);  // (1 + .01) / (2 + 1 + 3 + .01)
  EXPECT_DOUBLE_EQ(fd.impedance[0], -2.0);
  EXPECT_DOUBLE_EQ(fd.impedance[2], -3.0);
  EXPECT_TRUE(std::isnan(fd.impedance[3]));
}

/// tests/report/STUDY.md#frozen-actuator.
TEST(FiniteDifferences, AFrozenActuatorDividesByNothing) {
  constexpr std::array<double, 3> kStill{1, 1, 1}, kForce{1, 2, 0};
  const FiniteDifferences fd = finite_differences(kStill, kForce);
  EXPECT_EQ(fd.kept, 0);
  EXPECT_EQ(fd.all_nonpassive_pct, 0.0);
  EXPECT_EQ(fd.energy_weighted_pct, 0.0);
  EXPECT_EQ(finite_differences({}, {}).steps, 0);
}

}  // namespace
}  // namespace haptic::core
