// The rule that judges every row of tests/bench, on blocks with given figures.
#include "tests/bench/paired.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace {

using haptic::bench::Block;
using haptic::bench::Figure;
using haptic::bench::Row;

/// Returns these figures in turn.
Block turns(std::vector<double> values) {
  return [values, i = std::size_t{0}]() mutable { return values[i++ % values.size()]; };
}
Block always(double value) {
  return turns({value});
}
template <typename T>
std::string printed(const T& row) {
  testing::internal::CaptureStdout();
  print(row);
  std::string line = testing::internal::GetCapturedStdout();
  if (!line.empty()) line.pop_back();  // its end
  return line.substr(line.rfind(',') + 1);
}
Row row(const Block& ours, const Block& theirs, double target) {
  return haptic::bench::compare("ours", "theirs", "ns", ours, theirs, target, 20);
}

TEST(Paired, VerdictIsTheLinesLastField) {
  EXPECT_EQ(printed(row(always(9.0), always(10.0), 1.2)), "met");
  EXPECT_EQ(printed(row(always(12.0), always(10.0), 1.2)), "met");
  EXPECT_EQ(printed(row(always(13.0), always(10.0), 1.2)), "missed");
  EXPECT_EQ(printed(row(always(13.0), always(10.0), 0.0)), "reported");
}

TEST(Paired, MissWithinNoiseIsNotResolvable) {
  // The order of their two blocks turns: 10 and 15, 15 and 10, ... after one block of warm-up.
  const auto against_noise = [](double ours) {
    return row(always(ours), turns({10.0, 10.0, 15.0, 15.0}), 1.2);
  };
  EXPECT_DOUBLE_EQ(against_noise(14.0).a_a.upper, 1.5);
  EXPECT_EQ(printed(against_noise(14.0)), "not shown");
  EXPECT_EQ(printed(against_noise(30.0)), "missed");
}

TEST(Paired, DifferencesAreOverPairsToo) {
  const auto blocks = [](const Block& block) { return [block] { return std::vector{block()}; }; };
  Row r = haptic::bench::compare_all({"ours"}, "theirs", "us", blocks(turns({11.0, 13.0})),
                                     blocks(always(10.0)), 20, haptic::bench::Pairs::kDifference)
              .front();
  r.target = 2.0;
  EXPECT_DOUBLE_EQ(r.ratio.median, 2.0);
  EXPECT_DOUBLE_EQ(r.ratio.lower, 1.0);
  EXPECT_DOUBLE_EQ(r.ratio.upper, 3.0);
  EXPECT_DOUBLE_EQ(r.a_a.upper, 0.0);
  EXPECT_EQ(printed(r), "not shown") << "the target is within the interval";
}

}  // namespace
