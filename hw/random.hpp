#pragma once
/// Uniform and normally distributed numbers from a seed. Unlike std::normal_distribution they are
/// the same with every standard library.
/// Source: G. Marsaglia, T. A. Bray, SIAM Review 6(3):260-264, 1964 (polar method).

#include <cmath>
#include <cstdint>
#include <random>

namespace haptic::hw {

/// Uniform in [0, 1) with 53 random bits; the generator's words are fixed by the C++ standard.
[[nodiscard]] inline double uniform(std::mt19937_64& generator) {
  return static_cast<double>(generator() >> 11) * 0x1p-53;
}

class Gaussian {
 public:
  explicit Gaussian(std::uint64_t seed) : generator_(seed) {}

  /// Mean 0, standard deviation 1. Allocates nothing.
  [[nodiscard]] double operator()() noexcept {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    double u = 0.0, v = 0.0, s = 0.0;
    do {
      u = 2.0 * uniform(generator_) - 1.0;
      v = 2.0 * uniform(generator_) - 1.0;
      s = u * u + v * v;
    } while (s >= 1.0 || s == 0.0);
    const double scale = std::sqrt(-2.0 * std::log(s) / s);
    spare_ = v * scale;
    has_spare_ = true;
    return u * scale;
  }

 private:
  std::mt19937_64 generator_;
  double spare_{0.0};
  bool has_spare_{false};
};

}  // namespace haptic::hw
