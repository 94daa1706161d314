#pragma once
/// Bootstrap 95 % interval of a statistic, the same in every run.

#include <algorithm>
#include <numeric>
#include <vector>

#include "tests/report/csv.hpp"
#include "tests/support/link/random.hpp"

namespace haptic::report {

struct Interval {
  double value{0.0}, lower{0.0}, upper{0.0};
};
/// Three cells.
[[nodiscard]] inline std::string cell(const Interval& interval) {
  return line_of(interval.value, interval.lower, interval.upper).text;
}

/// `statistic` gets indices below n, in any number of repetitions.
template <typename Statistic>
[[nodiscard]] Interval interval_of(std::size_t n, const Statistic& statistic) {
  constexpr int kResamples = 1000;
  constexpr std::uint64_t kSeed = 19;
  std::vector<std::size_t> index(n);
  std::iota(index.begin(), index.end(), std::size_t{0});
  Interval interval{statistic(index)};
  test::Random random(kSeed);
  std::vector<double> found;
  for (int i = 0; i < kResamples; ++i) {
    for (std::size_t& one : index) one = random.next() % n;
    found.push_back(statistic(index));
  }
  std::sort(found.begin(), found.end());
  interval.lower = found[kResamples * 25 / 1000];
  interval.upper = found[kResamples * 975 / 1000 - 1];
  return interval;
}

}  // namespace haptic::report
