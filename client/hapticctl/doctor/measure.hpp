#pragma once
/// What the doctor asks this very host.

#include "doctor/examine.hpp"

namespace haptic::ctl {

/// Lateness of a list of wake-ups, us, in any order; `skipped` deadlines beside them.
[[nodiscard]] Jitter summarise(std::vector<double> lateness_us, std::uint64_t skipped);

/// Asks for SCHED_FIFO on a thread of its own, looks at limits and capabilities, and runs a bare loop
/// for `seconds` at `period_s`, with real-time scheduling where it is granted. Blocks.
[[nodiscard]] HostAnswers ask_host(double seconds, double period_s);

}  // namespace haptic::ctl
