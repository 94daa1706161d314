#include "server/base/rolling_histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace {

using namespace std::chrono_literals;
using haptic::core::Duration;
using haptic::core::TimePoint;
using haptic::server::Percentiles;
using haptic::server::RollingHistogram;

constexpr TimePoint kBeginning{Duration(1h)};

TEST(RollingHistogram, IsZeroBeforeTheFirstValue) {
  const RollingHistogram histogram;
  const Percentiles read = histogram.read();
  EXPECT_EQ(read.count, 0u);
  EXPECT_EQ(read.p50, 0ns);
  EXPECT_EQ(read.p99, 0ns);
  EXPECT_EQ(read.max, 0ns);
}

TEST(RollingHistogram, PercentilesAreWithinASixtyFourth) {
  RollingHistogram histogram;
  std::vector<std::int64_t> values;
  std::uint64_t random = 7;
  for (int i = 0; i < 4000; ++i) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    // 1 ns to 10 ms, evenly over the orders of magnitude.
    const double exponent = 7.0 * static_cast<double>(random >> 11) * 0x1p-53;
    values.push_back(static_cast<std::int64_t>(std::pow(10.0, exponent)));
    histogram.add(kBeginning + i * 1ms, Duration(values.back()));
  }
  std::sort(values.begin(), values.end());
  const Percentiles read = histogram.read();
  EXPECT_EQ(read.count, 4000u);
  EXPECT_EQ(read.max.count(), values.back());
  const auto near = [](Duration got, std::int64_t exact) {
    return std::abs(static_cast<double>(got.count() - exact)) <=
           static_cast<double>(exact) / 64.0 + 1.0;
  };
  EXPECT_TRUE(near(read.p50, values[1999])) << read.p50.count() << " " << values[1999];
  EXPECT_TRUE(near(read.p99, values[3959])) << read.p99.count() << " " << values[3959];
}

TEST(RollingHistogram, PowersOfTwoReadBack) {
  for (int bit = 0; bit < 40; ++bit) {
    for (const std::int64_t offset : {-1, 0, 1}) {
      const std::int64_t ns = (std::int64_t{1} << bit) + offset;
      RollingHistogram histogram;
      histogram.add(kBeginning, Duration(ns));
      histogram.add(kBeginning, Duration(2 * ns + 100));  // keeps the maximum away from the median
      const auto p50 = static_cast<double>(histogram.read().p50.count());
      ASSERT_NEAR(p50, static_cast<double>(ns), static_cast<double>(ns) / 64.0 + 0.5) << ns;
    }
  }
}

TEST(RollingHistogram, ForgetsAfterTwoWindows) {
  RollingHistogram histogram;
  histogram.add(kBeginning, 9ms);
  histogram.add(kBeginning + 4s, 1us);
  EXPECT_EQ(histogram.read().max, 9ms);
  histogram.add(kBeginning + 6s, 2us);  // one window on: the 9 ms are still in the other one
  EXPECT_EQ(histogram.read().max, 9ms);
  EXPECT_EQ(histogram.read().count, 3u);
  histogram.add(kBeginning + 12s, 3us);
  EXPECT_EQ(histogram.read().max, 3us);
  EXPECT_EQ(histogram.read().count, 2u);
}

TEST(RollingHistogram, ClampsValuesToItsRange) {
  RollingHistogram histogram;
  histogram.add(kBeginning, -5ns);
  EXPECT_EQ(histogram.read().max, 0ns);
  histogram.add(kBeginning, 48h);
  EXPECT_EQ(histogram.read().max, Duration((std::int64_t{1} << 40) - 1));
}

}  // namespace
