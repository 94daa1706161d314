#pragma once
/// What the ticks of one device add up to since the start: the part of the metrics that has to be
/// counted as it happens. Fed by the telemetry drain; the loop knows nothing of it.

#include <array>
#include <cstdint>
#include <functional>
#include <mutex>
#include <utility>

#include "server/ingress/ingress.hpp"
#include "server/metrics/exposition.hpp"
#include "server/telemetry/telemetry.hpp"

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
  core::TickRecord newest{};
};

class TickMetrics final : public RecordListener {
 public:
  /// `carrier`: of the newest accepted sample; called on the drain's thread.
  explicit TickMetrics(std::function<Carrier()> carrier) : carrier_(std::move(carrier)) {}

  void on_record(const core::TickRecord& record) override;
  /// Any thread; a copy, so that nobody formats text under the drain's mutex.
  [[nodiscard]] TickTotals totals() const;

 private:
  void count_carrier(const core::TickRecord& record, double seconds);

  const std::function<Carrier()> carrier_;
  mutable std::mutex mutex_;
  TickTotals totals_{};
  std::uint32_t carrier_epoch_{0};
  Carrier last_carrier_{Carrier::kNone};
};

}  // namespace haptic::server
