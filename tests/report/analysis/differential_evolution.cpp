#include "tests/report/analysis/differential_evolution.hpp"

#include <algorithm>
#include <random>

namespace haptic::core {

namespace {

constexpr double kCrossover = 0.9;
constexpr double kTowardsBest = 0.3;  ///< share of trials that start on the way to the best point

/// std::uniform_real_distribution may differ between libraries; the engine may not.
double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11U) * 0x1p-53;
}

}  // namespace

std::vector<double> minimise(const std::function<double(const std::vector<double>&)>& cost,
                             const std::vector<Interval>& box, const Evolution& evolution) {
  const std::size_t n = box.size(), members = static_cast<std::size_t>(evolution.population);
  std::mt19937_64 random(evolution.seed);
  std::vector<std::vector<double>> at(members, std::vector<double>(n));
  std::vector<double> costs(members);
  for (std::size_t i = 0; i < members; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      at[i][k] = box[k].lower + uniform(random) * (box[k].upper - box[k].lower);
    }
    costs[i] = cost(at[i]);
  }
  const auto best = [&] {
    return static_cast<std::size_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  };
  for (int generation = 0; generation < evolution.generations; ++generation) {
    for (std::size_t i = 0; i < members; ++i) {
      const std::size_t b = best();
      const std::size_t r1 = random() % members, r2 = random() % members, r3 = random() % members;
      const double weight = 0.4 + 0.6 * uniform(random);
      const std::size_t always = random() % n;
      const bool towards_best = uniform(random) < kTowardsBest;
      std::vector<double> trial = at[i];
      for (std::size_t k = 0; k < n; ++k) {
        if (k != always && uniform(random) >= kCrossover) continue;
        const double base = towards_best ? at[i][k] + weight * (at[b][k] - at[i][k]) : at[r3][k];
        trial[k] = std::clamp(base + weight * (at[r1][k] - at[r2][k]), box[k].lower, box[k].upper);
      }
      const double trial_cost = cost(trial);
      if (trial_cost > costs[i]) continue;
      costs[i] = trial_cost;
      at[i] = std::move(trial);
    }
  }
  return at[best()];
}

}  // namespace haptic::core
