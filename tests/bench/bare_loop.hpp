#pragma once
/// A loop of 1 kHz that does nothing, with hapticd's wishes of real time, in the calling thread.

#include <cstdint>
#include <ctime>

#include "server/owner/loop/realtime.hpp"

namespace haptic::bench {

inline constexpr std::int64_t kSecondNs = 1'000'000'000, kTickNs = 1'000'000;

/// Until on_tick(lateness in us, deadlines that passed meanwhile) returns false.
template <typename OnTick>
void bare_loop(const OnTick& on_tick) {
  const auto now_ns = [] {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * kSecondNs + now.tv_nsec;
  };
  static_cast<void>(server::apply_realtime({}, server::real_host()));
  std::int64_t deadline = now_ns(), late = 0;
  do {
    deadline += kTickNs + late / kTickNs * kTickNs;
    const timespec at{static_cast<std::time_t>(deadline / kSecondNs),
                      static_cast<long>(deadline % kSecondNs)};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
    late = now_ns() - deadline;
  } while (on_tick(static_cast<double>(late) * 1e-3, late / kTickNs));
}

}  // namespace haptic::bench
