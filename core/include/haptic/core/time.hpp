#pragma once
/// Time inside core: points on the server's steady clock. There is no now() here; the caller who
/// ticks says what time it is, so that every rule runs on recorded and on virtual time alike.

#include <chrono>
#include <cmath>
#include <cstdint>

namespace haptic::core {

using Duration = std::chrono::nanoseconds;

/// The server's steady clock, without the means to read it.
struct SteadyClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = Duration;
  using time_point = std::chrono::time_point<SteadyClock, Duration>;
  static constexpr bool is_steady = true;
};

using TimePoint = SteadyClock::time_point;

[[nodiscard]] constexpr double seconds(Duration d) noexcept {
  return std::chrono::duration<double>(d).count();
}

/// The nearest nanosecond; |s| < 9e9.
[[nodiscard]] inline Duration duration(double s) noexcept {
  return Duration(std::llround(s * 1e9));
}

}  // namespace haptic::core
