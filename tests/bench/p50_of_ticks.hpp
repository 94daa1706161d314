#pragma once
#include <algorithm>
#include <chrono>
#include <vector>

namespace haptic::bench {

/// p50 of single ticks in ns: of 3000, after 1000 to warm up. `input(i)` makes what tick i is
/// given, `tick(input)` is what is measured; the clock's own cost, measured in the same block, is
/// taken off.
template <typename Input, typename Tick>
double p50_of_ticks(const Input& input, const Tick& tick) {
  using Clock = std::chrono::steady_clock;
  constexpr int kWarmUp = 1000, kTicks = 3000;
  std::vector<double> ticks, clocks;
  for (int i = 0; i < kWarmUp + kTicks; ++i) {
    const auto given = input(i);
    const auto before = Clock::now(), start = Clock::now();
    tick(given);
    const auto end = Clock::now();
    if (i < kWarmUp) continue;
    clocks.push_back(std::chrono::duration<double, std::nano>(start - before).count());
    ticks.push_back(std::chrono::duration<double, std::nano>(end - start).count());
  }
  const auto median = [](std::vector<double>& values) {
    std::nth_element(values.begin(), values.begin() + kTicks / 2, values.end());
    return values[kTicks / 2];
  };
  return median(ticks) - median(clocks);
}

}  // namespace haptic::bench
