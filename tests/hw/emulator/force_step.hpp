#pragma once
/// Figures of a step of a force reference.

#include <algorithm>
#include <cmath>

namespace haptic::test {

struct ForceStep {
  double rise{0.0};       ///< s, 10 to 90 % of the step
  double bandwidth{0.0};  ///< Hz: 0.35 / rise, that of a first-order response with this rise
  double overshoot{0.0};  ///< share of the step
  bool settled{false};    ///< within `band` (share of the step) throughout the last second
};

/// Holds `from` for `settle` ms and then `to` for as long. `tick(reference)`: the true force 1 ms
/// later. All in N.
template <typename Tick>
[[nodiscard]] ForceStep measure_force_step(Tick&& tick, double from, double to, int settle,
                                           double band) {
  for (int i = 0; i < settle; ++i) static_cast<void>(tick(from));
  ForceStep step{.settled = true};
  double at_10 = -1.0, at_90 = -1.0, peak = 0.0;
  for (int i = 1; i <= settle; ++i) {
    const double share = (tick(to) - from) / (to - from);
    if (at_10 < 0.0 && share >= 0.1) at_10 = 1e-3 * i;
    if (at_90 < 0.0 && share >= 0.9) at_90 = 1e-3 * i;
    peak = std::max(peak, share);
    if (i > settle - 1000 && std::abs(share - 1.0) > band) step.settled = false;
  }
  if (at_90 < 0.0) return {};
  step.rise = std::max(at_90 - at_10, 1e-3);
  step.bandwidth = 0.35 / step.rise;
  step.overshoot = std::max(0.0, peak - 1.0);
  return step;
}

}  // namespace haptic::test
