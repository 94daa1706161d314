#pragma once
/// Counts what the ticks of each device add up to: the part of the metrics that has to be counted
/// as it happens. It is the owner's, so that the counters survive a front.

#include <mutex>
#include <vector>

#include "server/crossing/ports.hpp"
#include "server/crossing/tick_totals.hpp"

namespace haptic::server {

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
