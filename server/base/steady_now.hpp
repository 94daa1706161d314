#pragma once
/// The server's steady clock as the network side reads it: at the arrival of a sample.

#include <chrono>
#include <functional>

#include "haptic/core/time.hpp"

namespace haptic::server {

[[nodiscard]] inline core::TimePoint steady_now() noexcept {
  return core::TimePoint(std::chrono::duration_cast<core::Duration>(
      std::chrono::steady_clock::now().time_since_epoch()));
}

/// Arrival time of data that has waited `waited` since. A test in lock-step stamps arrivals by a
/// clock of its own. Any thread.
using ArrivalClock = std::function<core::TimePoint(core::Duration waited)>;

[[nodiscard]] inline core::TimePoint steady_arrival(core::Duration waited) noexcept {
  return steady_now() - waited;
}

}  // namespace haptic::server
