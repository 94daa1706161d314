#pragma once
/// Order statistics of measured values.

#include <algorithm>
#include <cstddef>
#include <vector>

namespace haptic::test {

/// The value below which the share p (0..1) of `values` lies, in their order; 0 of none. p 0.5: the
/// median, of an even number of values the upper one.
inline double percentile(std::vector<double> values, double p) {
  if (values.empty()) return 0.0;
  const auto at =
      std::min(values.size() - 1, static_cast<std::size_t>(p * static_cast<double>(values.size())));
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(at);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace haptic::test
