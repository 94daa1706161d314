#pragma once
/// Measures the host that it runs on.

#include "doctor/examine.hpp"

namespace haptic::ctl {

/// From the lateness of wake-ups, us, in any order, and the number of deadlines that were skipped.
[[nodiscard]] Jitter summarise(std::vector<double> lateness_us, std::uint64_t skipped);

/// Asks for SCHED_FIFO on a thread of its own, reads limits and capabilities, and runs a bare loop
/// for `seconds` at `period_s`, with real-time scheduling if it is granted. Blocks.
[[nodiscard]] HostAnswers ask_host(double seconds, double period_s);

}  // namespace haptic::ctl
