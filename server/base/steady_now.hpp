#pragma once
/// The server's steady clock, where the network side reads it: at the arrival of a sample.

#include <chrono>
#include <functional>

#include "haptic/core/time.hpp"

namespace haptic::server {

[[nodiscard]] inline core::TimePoint steady_now() noexcept {
  return core::TimePoint(std::chrono::duration_cast<core::Duration>(
      std::chrono::steady_clock::now().time_since_epoch()));
}

/// When that came which has waited for so long since then. A test in lock-step stamps arrivals by a
/// clock of its own; any thread calls it.
using ArrivalClock = std::function<core::TimePoint(core::Duration waited)>;

[[nodiscard]] inline core::TimePoint steady_arrival(core::Duration waited) noexcept {
  return steady_now() - waited;
}

}  // namespace haptic::server
