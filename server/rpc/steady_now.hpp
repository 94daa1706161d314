#pragma once
/// The server's steady clock, where the network side reads it: at the arrival of a sample.

#include <chrono>

#include "haptic/core/time.hpp"

namespace haptic::server {

[[nodiscard]] inline core::TimePoint steady_now() noexcept {
  return core::TimePoint(std::chrono::duration_cast<core::Duration>(
      std::chrono::steady_clock::now().time_since_epoch()));
}

}  // namespace haptic::server
