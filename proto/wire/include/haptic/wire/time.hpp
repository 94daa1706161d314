#pragma once
/// Time in the rules of the wire: points on the steady clock of the program that uses them. There
/// is no now() here, so that every rule runs on virtual time.

#include <chrono>
#include <cstdint>

namespace haptic::wire {

using Duration = std::chrono::nanoseconds;

/// A steady clock without the means to read it; std::chrono::steady_clock's epoch in both programs.
struct SteadyClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = Duration;
  using time_point = std::chrono::time_point<SteadyClock, Duration>;
  static constexpr bool is_steady = true;
};

using TimePoint = SteadyClock::time_point;

}  // namespace haptic::wire
