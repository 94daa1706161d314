#include "skyline.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace haptic::mujoco {

void Skyline::begin(std::size_t n) {
  first_.resize(n);
  std::iota(first_.begin(), first_.end(), std::size_t{0});
  entries_.clear();
}

void Skyline::reach(std::size_t i, std::size_t k) {
  first_[i] = std::min(first_[i], k);
}

void Skyline::allocate() {
  diagonal_.resize(first_.size());
  std::size_t end = 0;
  for (std::size_t i = 0; i < first_.size(); ++i) {
    diagonal_[i] = end + i - first_[i];  // no less than i, as each row has an entry
    end = diagonal_[i] + 1;
  }
  entries_.assign(end, 0.0);
}

void Skyline::factor() {
  for (std::size_t i = 0; i < first_.size(); ++i) {
    double* const at = row(i);
    for (std::size_t k = first_[i]; k <= i; ++k) {
      const double* const before = row(k);
      const std::size_t from = std::max(first_[i], first_[k]);
      const double left = at[k] - mju_dot(at + from, before + from, static_cast<int>(k - from));
      at[k] = k < i ? left / before[k] : std::sqrt(std::max<double>(left, mjMINVAL));
    }
  }
}

void Skyline::solve(std::vector<double>& x) const {
  const std::size_t n = first_.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double* const at = row(i);
    for (std::size_t k = first_[i]; k < i; ++k) x[i] -= at[k] * x[k];
    x[i] /= at[i];
  }
  for (std::size_t i = n; i-- > 0;) {
    const double* const at = row(i);
    x[i] /= at[i];
    for (std::size_t k = first_[i]; k < i; ++k) x[k] -= at[k] * x[i];
  }
}

}  // namespace haptic::mujoco
