#pragma once
/// The time of single calls.

#include <chrono>
#include <vector>

#include "tests/support/percentile.hpp"

namespace haptic::bench {

/// p50 in ns of `calls` calls, after `warm_up` that do not count. `prepare(i)` makes what call i is
/// given, `call(given)` is measured; the clock's own cost, measured next to it, is subtracted.
template <typename Prepare, typename Call>
double p50_of_calls(int warm_up, int calls, const Prepare& prepare, const Call& call) {
  using Clock = std::chrono::steady_clock;
  using Ns = std::chrono::duration<double, std::nano>;
  std::vector<double> spent, clock;
  for (int i = 0; i < warm_up + calls; ++i) {
    const auto& given = prepare(i);
    const auto before = Clock::now(), start = Clock::now();
    call(given);
    const auto end = Clock::now();
    if (i < warm_up) continue;
    clock.push_back(Ns(start - before).count());
    spent.push_back(Ns(end - start).count());
  }
  return test::percentile(spent, 0.5) - test::percentile(clock, 0.5);
}

}  // namespace haptic::bench
