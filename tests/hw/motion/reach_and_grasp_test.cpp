#include "hw/motion/reach_and_grasp.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "haptic/core/error.hpp"
#include "hw/motion/minimum_jerk.hpp"

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

TEST(ReachAndGrasp, TheShippedFileIsGenerated) {
  std::ifstream file(HAPTIC_SOURCE_DIR "/server/scenes/motion/reach_and_grasp.csv",
                     std::ios::binary);
  ASSERT_TRUE(file) << "server/scenes/motion/reach_and_grasp.csv";
  const std::string shipped(std::istreambuf_iterator<char>(file), {});
  std::ostringstream made;
  write_motion_csv(made, make_reach_and_grasp({}));
  EXPECT_TRUE(shipped == made.str())
      << "make it anew: haptic-make-motion --output server/scenes/motion/reach_and_grasp.csv";
  EXPECT_LE(shipped.size(), 100'000u);
}

TEST(ReachAndGrasp, AnotherSeedIsAnotherMotion) {
  const auto a = make_reach_and_grasp({.seed = 1});
  const auto b = make_reach_and_grasp({.seed = 2});
  double difference = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference = std::max(difference, std::abs(a[i].mcp - b[i].mcp));
  }
  EXPECT_GT(difference, 0.3);
}

TEST(ReachAndGrasp, HasTheAskedLengthAndRate) {
  const auto rows = make_reach_and_grasp({.seconds = 3.0, .rate = 250.0});
  ASSERT_EQ(rows.size(), 751u);
  EXPECT_EQ(rows.front().time, 0.0);
  EXPECT_DOUBLE_EQ(rows.back().time, 3.0);
}

TEST(ReachAndGrasp, OpensAndClosesLikeAHand) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto rows = make_reach_and_grasp({.seed = seed});
    const auto [open, closed] = std::minmax_element(
        rows.begin(), rows.end(),
        [](const JointAngles& a, const JointAngles& b) { return a.mcp < b.mcp; });
    EXPECT_GT(open->mcp, -0.02);
    EXPECT_LT(open->mcp, 0.15);
    EXPECT_GT(closed->mcp, 0.7);
    EXPECT_LT(closed->mcp, 1.05);
    // Ends as it began, at rest, so that it repeats without a jump.
    EXPECT_NEAR(rows.front().mcp, rows.back().mcp, 0.05);
    EXPECT_NEAR(rows.front().pip, rows.back().pip, 0.05);
    for (std::size_t i = 1; i < rows.size(); ++i) {
      const double dt = rows[i].time - rows[i - 1].time;
      EXPECT_LT(std::abs(rows[i].mcp - rows[i - 1].mcp) / dt, 8.0);  // rad/s
      EXPECT_LT(std::abs(rows[i].pip - rows[i - 1].pip) / dt, 8.0);
    }
  }
}

TEST(ReachAndGrasp, TremorHasSizeAndBand) {
  const ReachAndGrasp with{.seconds = 60.0, .rate = 200.0};
  ReachAndGrasp without = with;
  without.tremor_rms = 0.0;
  const auto a = make_reach_and_grasp(with);
  const auto b = make_reach_and_grasp(without);
  double square = 0.0;
  int crossings = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double tremor = a[i].pip - b[i].pip;
    square += tremor * tremor;
    if (i > 0 && tremor * (a[i - 1].pip - b[i - 1].pip) < 0.0) ++crossings;
  }
  EXPECT_NEAR(std::sqrt(square / static_cast<double>(a.size())), 0.001, 1e-4);
  const double mean_frequency = crossings / 2.0 / 60.0;
  EXPECT_GT(mean_frequency, 8.0);
  EXPECT_LT(mean_frequency, 12.0);
}

TEST(ReachAndGrasp, NamesAnOptionOutOfRange) {
  EXPECT_THROW(static_cast<void>(make_reach_and_grasp({.seconds = 0.0})), core::DeviceError);
  EXPECT_THROW(static_cast<void>(make_reach_and_grasp({.seconds = 1e9})), core::DeviceError);
  EXPECT_THROW(static_cast<void>(make_reach_and_grasp({.rate = 0.0})), core::DeviceError);
  EXPECT_THROW(static_cast<void>(make_reach_and_grasp({.rate = std::nan("")})), core::DeviceError);
  EXPECT_THROW(static_cast<void>(make_reach_and_grasp({.tremor_rms = -1.0})), core::DeviceError);
}

}  // namespace
}  // namespace haptic::hw
