#pragma once
/// Random numbers that are the same everywhere: the standard library's distributions are not.

#include <cmath>
#include <cstdint>
#include <numbers>

namespace haptic::test {

/// SplitMix64 (Steele, Lea, Flood 2014): any seed will do, also consecutive ones.
class Random {
 public:
  explicit constexpr Random(std::uint64_t seed) : state_(seed) {}
  /// A stream of its own for item `index` of `seed`: what is drawn for one never shifts another.
  constexpr Random(std::uint64_t seed, std::uint64_t index)
      : state_(Random(seed).next() ^ (index * 0x9E3779B97F4A7C15U)) {}

  constexpr std::uint64_t next() noexcept {
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15U;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }
  /// [0, 1)
  constexpr double uniform() noexcept { return static_cast<double>(next() >> 11U) * 0x1p-53; }
  /// Mean 0, sigma 1 (Box and Muller).
  double normal() noexcept {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }
  /// Mean 1.
  double exponential() noexcept { return -std::log(1.0 - uniform()); }

 private:
  std::uint64_t state_;
};

}  // namespace haptic::test
