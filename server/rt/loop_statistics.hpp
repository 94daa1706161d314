#pragma once
/// Percentiles of the last 5 to 10 s, written by the loop without locks, read by anyone.

#include <array>
#include <atomic>
#include <cstdint>

#include "haptic/core/time.hpp"

namespace haptic::server {

/// Log-linear buckets: each power of two of nanoseconds in 16 parts, so that a percentile is good to
/// 6 %.
class DurationHistogram {
 public:
  void add(core::Duration value) noexcept;
  void clear() noexcept;
  void add_to(std::array<std::uint64_t, 1024>& counts) const noexcept;
  [[nodiscard]] static core::Duration upper_edge(std::size_t bucket) noexcept;

 private:
  static constexpr unsigned kParts = 16;
  static std::size_t bucket_of(std::uint64_t ns) noexcept;
  std::array<std::atomic<std::uint32_t>, 1024> counts_{};
};

struct Percentiles {
  double p50_us{0.0}, p99_us{0.0}, max_us{0.0};
};

/// Two windows of 5 s: one is filled, the other is the past. Reading adds both.
class SlidingPercentiles {
 public:
  static constexpr core::Duration kWindow{std::chrono::seconds(5)};
  /// The loop's thread only.
  void add(core::Duration value, core::TimePoint now) noexcept;
  [[nodiscard]] Percentiles read() const noexcept;

 private:
  std::array<DurationHistogram, 2> windows_{};
  std::atomic<unsigned> current_{0};
  core::TimePoint started_{};
};

}  // namespace haptic::server
