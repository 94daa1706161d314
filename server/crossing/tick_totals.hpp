#pragma once
/// Sums over the ticks of a device since the start.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "server/crossing/crossing.hpp"

namespace haptic::server {

/// Values counted by upper bounds, as a scrape shows them.
struct HistogramView {
  std::span<const double> bounds{};
  /// Values in (bound i - 1, bound i]; the last entry is what is above all.
  std::span<const std::uint64_t> counts{};
  double sum{0.0};
};

/// `kBounds`: an array, ascending; what is above the last goes to +Inf.
template <const auto& kBounds>
class Histogram {
 public:
  void add(double value) noexcept {
    const auto bound = std::lower_bound(kBounds.begin(), kBounds.end(), value);
    ++counts_[static_cast<std::size_t>(bound - kBounds.begin())];
    sum_ += value;
  }
  [[nodiscard]] double sum() const noexcept { return sum_; }
  operator HistogramView() const noexcept {  // NOLINT(google-explicit-constructor): it is one
    return {kBounds, counts_, sum_};
  }

 private:
  std::array<std::uint64_t, kBounds.size() + 1> counts_{};
  double sum_{0.0};
};

// Bounds in seconds. The period is looked at around 1 ms; lateness from the few microseconds of an
// idle real-time host to the 20 ms of LOOP_LATE; ages by the levels of
// proto/README.md#staleness-and-gain (5..80, 100, 180 ms).
inline constexpr std::array<double, 13> kPeriods{0.0005,  0.0008,  0.0009, 0.00095, 0.00098,
                                                 0.00102, 0.00105, 0.0011, 0.0012,  0.0015,
                                                 0.002,   0.005,   0.02};
inline constexpr std::array<double, 13> kLateness{
    5e-6, 1e-5, 2e-5, 5e-5, 0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.008, 0.01, 0.02};
inline constexpr std::array<double, 13> kAges{0.001, 0.002, 0.005, 0.01, 0.02, 0.03, 0.04,
                                              0.05,  0.08,  0.1,   0.13, 0.18, 0.5};
/// A board's samples: fine around the targets, 2 ms streaming and 4 ms at 500 Hz
/// (hw/README.md#the-board-device), and below half a millisecond, which is usual in a loop that
/// they pace.
inline constexpr std::array<double, 17> kSampleAges{5e-5,   0.0001,  0.0002, 0.0005, 0.001, 0.00125,
                                                    0.0015, 0.00175, 0.002,  0.0025, 0.003, 0.0035,
                                                    0.004,  0.005,   0.007,  0.01,   0.1};

struct TickTotals {
  Histogram<kPeriods> period{};         ///< s, from tick to tick
  Histogram<kLateness> lateness{};      ///< s, of the wake-up behind its deadline
  Histogram<kAges> age{};               ///< s, of the proxy at its use; ticks without one are none
  Histogram<kSampleAges> sample_age{};  ///< s, of the device's newest sample at its use in a tick
  std::array<double, 4> level_s{};      ///< s in FRESH, HOLD, FADE, LOST while a lease is held
  std::array<double, kCarriers> carrier_s{};  ///< s led by samples of each Carrier, under a lease
  std::uint64_t carrier_changes{0};           ///< between GRPC and UDP, under one lease
  std::array<std::uint64_t, 32> limited{};    ///< ticks in which limiter n acted
  std::array<std::uint64_t, 32> faults{};     ///< times fault n latched
  std::uint64_t lost{0};                      ///< times force was given up for a late proxy
  // Values of the newest tick.
  core::LifecycleState state{core::LifecycleState::kInit};
  double gain{0.0};
  Values error_bound{};  ///< empty: unknown
  core::FaultSet active{};
  std::uint32_t carrier_tenure{0};       ///< of the newest tick under a lease
  Carrier last_carrier{Carrier::kNone};  ///< of that tick
};
static_assert(std::is_trivially_copyable_v<TickTotals> && std::is_standard_layout_v<TickTotals>);

}  // namespace haptic::server
