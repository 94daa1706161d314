#include "server/front/metrics/exposition.hpp"

#include <gtest/gtest.h>

#include <array>

namespace haptic::server {
namespace {

constexpr std::array<double, 2> kBounds{0.5, 2.0};

TEST(Exposition, HistogramIsCumulativeWithInclusiveBounds) {
  Histogram<kBounds> values;
  for (const double v : {0.25, 0.5, 0.75, 4.0}) values.add(v);
  Exposition page;
  page.histogram("x_seconds", "X.");
  page.sample({{"device", "a"}}, values);
  EXPECT_EQ(page.text(),
            "# HELP x_seconds X.\n"
            "# TYPE x_seconds histogram\n"
            "x_seconds_bucket{device=\"a\",le=\"0.5\"} 2\n"
            "x_seconds_bucket{device=\"a\",le=\"2\"} 3\n"
            "x_seconds_bucket{device=\"a\",le=\"+Inf\"} 4\n"
            "x_seconds_sum{device=\"a\"} 5.5\n"
            "x_seconds_count{device=\"a\"} 4\n");
}

TEST(Exposition, LargeCountsKeepEveryDigit) {
  Exposition page;
  page.counter("n_total", "N.");
  page.sample({}, 123456789012.0);
  page.sample({}, 0.1);
  EXPECT_EQ(page.text(),
            "# HELP n_total N.\n# TYPE n_total counter\nn_total 123456789012\nn_total 0.1\n");
}

TEST(Exposition, LabelsAreEscaped) {
  Exposition page;
  page.gauge("g", "G.");
  page.sample({{"scene", "a \"b\" \\ c\nd"}}, 1.0);
  EXPECT_EQ(page.text(), "# HELP g G.\n# TYPE g gauge\ng{scene=\"a \\\"b\\\" \\\\ c\\nd\"} 1\n");
}

}  // namespace
}  // namespace haptic::server
