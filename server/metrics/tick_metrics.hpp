#pragma once
/// What the ticks of each device add up to since the start: the part of the metrics that has to be
/// counted as it happens.

#include <array>
#include <cstdint>
#include <mutex>
#include <vector>

#include "server/crossing/ports.hpp"
#include "server/metrics/exposition.hpp"

namespace haptic::server {

struct TickTotals {
  TickTotals();

  Histogram period;      ///< s, from tick to tick
  Histogram lateness;    ///< s, of the wake-up behind its deadline
  Histogram age;         ///< s, of the proxy at its use in a tick; ticks without one do not count
  Histogram sample_age;  ///< s, of the device's newest sample at its use in a tick
  std::array<double, 4> level_s{};  ///< s in FRESH, HOLD, FADE, LOST while a lease is held
  std::array<double, 3>
      carrier_s{};                   ///< s led by samples of Carrier 0, 1, 2, while a lease is held
  std::uint64_t carrier_changes{0};  ///< between GRPC and UDP, under one lease
  std::array<std::uint64_t, 32> limited{};  ///< ticks in which limiter n acted
  std::array<std::uint64_t, 32> faults{};   ///< times fault n latched
  std::uint64_t lost{0};                    ///< times force was given up for a late proxy
  StateRecord newest{};
  std::uint32_t carrier_tenure{0};       ///< of the newest tick under a lease
  Carrier last_carrier{Carrier::kNone};  ///< of that tick
};

class TickMetrics final : public FrontPort {
 public:
  explicit TickMetrics(std::size_t devices) : totals_(devices) {}

  void on_tick(std::size_t device, const StateRecord& state) override;
  /// Any thread; a copy, so that no text is formatted under the drain's mutex.
  [[nodiscard]] TickTotals totals(std::size_t device) const;

 private:
  mutable std::mutex mutex_;
  std::vector<TickTotals> totals_;
};

}  // namespace haptic::server
