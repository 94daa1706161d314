#pragma once
/// Counts what the ticks of each device add up to: the part of the metrics that has to be counted
/// as it happens. It is the owner's, so that the counters survive a front.

#include <mutex>
#include <vector>

#include "server/crossing/tick_totals.hpp"
#include "server/owner/state/state_message.hpp"

namespace haptic::server {

class TickMetrics {
 public:
  explicit TickMetrics(std::size_t devices) : totals_(devices) {}

  /// Every tick of the device, in order.
  void count(std::size_t device, const TickTold& told);
  /// Any thread; a copy, so that no text is formatted under the drain's mutex.
  [[nodiscard]] TickTotals totals(std::size_t device) const;

 private:
  mutable std::mutex mutex_;
  std::vector<TickTotals> totals_;
};

}  // namespace haptic::server
