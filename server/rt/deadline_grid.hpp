#pragma once
/// The loop's deadlines: start, start + period, start + 2 period ... The grid never moves. A loop that
/// wakes late serves the newest deadline it missed and skips the others: late ticks are counted, never
/// made up for in a burst.

#include <algorithm>

#include "haptic/core/tick/tick_input.hpp"

namespace haptic::server {

class DeadlineGrid {
 public:
  DeadlineGrid(core::TimePoint first, core::Duration period) : deadline_(first), period_(period) {}

  /// What the loop is to sleep until.
  [[nodiscard]] core::TimePoint deadline() const noexcept { return deadline_; }

  /// The loop woke at `now` for deadline(). Lateness is counted from that deadline, also where it was
  /// passed over by whole periods. Waking early (a clock that was set) is not late.
  core::LoopReport woke(core::TimePoint now) noexcept {
    core::LoopReport report;
    report.lateness = std::max(now - deadline_, core::Duration::zero());
    const auto missed = report.lateness / period_;
    report.skipped = static_cast<std::uint32_t>(std::min<decltype(missed)>(missed, 0xffffffffLL));
    deadline_ += period_ * (missed + 1);
    return report;
  }

 private:
  core::TimePoint deadline_;
  core::Duration period_;
};

}  // namespace haptic::server
