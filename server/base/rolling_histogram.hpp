#pragma once
/// Durations of the last seconds as percentiles: written by one real-time thread without locks,
/// read by anyone.
///
/// Log-linear buckets: 32 to each power of two of nanoseconds, so that a percentile is right within
/// 1/64 of itself. Two windows of 5 s take turns; a reading covers both, the last 5 to 10 s.

#include <array>
#include <atomic>
#include <cstdint>

#include "haptic/core/time.hpp"

namespace haptic::server {

struct Percentiles {
  std::uint64_t count{0};
  core::Duration p50{0};
  core::Duration p99{0};
  core::Duration max{0};  ///< exact
};

class RollingHistogram {
 public:
  static constexpr core::Duration kWindow{std::chrono::seconds(5)};

  /// One thread. Negative durations count as 0, those above 18 min as 18 min.
  void add(core::TimePoint now, core::Duration value) noexcept;

  /// Any thread. A window that is being emptied meanwhile may be seen half empty.
  [[nodiscard]] Percentiles read() const noexcept;

 private:
  static constexpr int kSubBits = 5;
  static constexpr int kHighestBit = 40;  ///< 2^40 ns = 18 min
  static constexpr std::size_t kBuckets = (kHighestBit - kSubBits + 1) << kSubBits;

  struct Window {
    std::array<std::atomic<std::uint32_t>, kBuckets> counts{};
    std::atomic<std::int64_t> max_ns{0};
  };
  static std::size_t bucket(std::uint64_t ns) noexcept;
  static core::Duration middle(std::size_t bucket) noexcept;
  void next_window(core::TimePoint now) noexcept;

  std::array<Window, 2> windows_{};
  std::size_t active_{0};           ///< the writer's
  core::TimePoint window_start_{};  ///< the writer's
};

}  // namespace haptic::server
