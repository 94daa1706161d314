#pragma once
/// Differential evolution (Storn and Price): a minimum of a function that has no gradient. The same
/// seed gives the same answer.

#include <cstdint>
#include <functional>
#include <vector>

namespace haptic::core {

struct Interval {
  double lower{0.0};
  double upper{0.0};
};

struct Evolution {
  std::uint64_t seed{1};
  int population{80};
  int generations{700};
};

/// The best point found within `box`, one interval per coordinate.
[[nodiscard]] std::vector<double> minimise(
    const std::function<double(const std::vector<double>&)>& cost, const std::vector<Interval>& box,
    const Evolution& evolution);

}  // namespace haptic::core
