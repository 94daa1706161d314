#include "tests/report/analysis/finite_differences.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic::core {

namespace {

double percent(double part, double whole) {
  return whole > 0.0 ? 100.0 * part / whole : 0.0;
}

}  // namespace

FiniteDifferences finite_differences(std::span<const double> q_a, std::span<const double> tau_a,
                                     const StepRule& rule, std::span<const char> gap_before) {
  FiniteDifferences result;
  const std::size_t n = std::min(q_a.size(), tau_a.size());
  const auto measured = [&](std::size_t i) {  // the step from i to i + 1
    return i + 1 >= gap_before.size() || gap_before[i + 1] == 0;
  };
  double squares = 0.0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    if (!measured(i)) continue;
    ++result.steps;
    squares += (q_a[i + 1] - q_a[i]) * (q_a[i + 1] - q_a[i]);
  }
  if (result.steps == 0) return result;
  // 5 sigma: noise alone then passes once in some million steps.
  const double smallest =
      std::max(rule.small_step * std::sqrt(squares / result.steps), 5.0 * rule.sigma_q);

  int kept_active = 0, moving = 0, moving_active = 0;
  double given = 0.0, exchanged = 0.0;
  result.impedance.assign(n - 1, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i + 1 < n; ++i) {
    if (!measured(i)) continue;
    const double dq = q_a[i + 1] - q_a[i];
    const double dtau = tau_a[i + 1] - tau_a[i];
    given += std::max(0.0, dtau * dq);
    exchanged += std::abs(dtau * dq);
    if (dq == 0.0) continue;
    const double ratio = dtau / dq;
    ++moving;
    moving_active += ratio > 0.0 ? 1 : 0;
    if (!(std::abs(dq) > smallest)) continue;
    ++result.kept;
    kept_active += ratio > 0.0 ? 1 : 0;
    result.impedance[i] = ratio;
  }
  result.nonpassive_pct = percent(kept_active, result.kept);
  result.excluded_pct = percent(result.steps - result.kept, result.steps);
  result.all_nonpassive_pct = percent(moving_active, moving);
  result.energy_weighted_pct = percent(given, exchanged);
  return result;
}

}  // namespace haptic::core
