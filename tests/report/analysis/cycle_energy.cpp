#include "tests/report/analysis/cycle_energy.hpp"

#include <algorithm>
#include <cstddef>

namespace haptic::core {

double cycle_work(std::span<const double> q_a, std::span<const double> tau_a,
                  Direction direction) noexcept {
  const std::size_t n = std::min(q_a.size(), tau_a.size());
  double work = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    // Reversed: the same samples from the last to the first, and from there back to the last.
    const std::size_t from = direction == Direction::kForward ? i : n - 1 - i;
    const std::size_t to = direction == Direction::kForward ? (i + 1) % n : (from + n - 1) % n;
    work += 0.5 * (tau_a[from] + tau_a[to]) * (q_a[to] - q_a[from]);
  }
  return work;
}

double lowest_running_energy(std::span<const double> q_a, std::span<const double> tau_a) noexcept {
  const std::size_t n = std::min(q_a.size(), tau_a.size());
  double energy = 0.0, lowest = 0.0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    energy -= 0.5 * (tau_a[i] + tau_a[i + 1]) * (q_a[i + 1] - q_a[i]);
    lowest = std::min(lowest, energy);
  }
  return lowest;
}

}  // namespace haptic::core
