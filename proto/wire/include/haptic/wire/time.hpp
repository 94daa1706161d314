#pragma once
/// Time in the rules of the wire: points on the steady clock of the program that uses them. No rule
/// reads the clock; times are arguments, so that every rule runs on virtual time.

#include <chrono>

namespace haptic::wire {

using Duration = std::chrono::nanoseconds;
using TimePoint = std::chrono::time_point<std::chrono::steady_clock, Duration>;

}  // namespace haptic::wire
