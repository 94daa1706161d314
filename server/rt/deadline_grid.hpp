#pragma once
/// When the loop ticks. The deadlines are a fixed grid, first + n period; a tick that comes late
/// never moves it, and deadlines that have passed meanwhile are skipped and counted, never made up
/// for.

#include "haptic/core/tick/tick_input.hpp"
#include "haptic/core/time.hpp"

namespace haptic::server {

class DeadlineGrid {
 public:
  /// period > 0.
  DeadlineGrid(core::TimePoint first, core::Duration period) : deadline_(first), period_(period) {}

  /// The deadline to wait for.
  [[nodiscard]] core::TimePoint deadline() const noexcept { return deadline_; }

  /// The wait for deadline() ended at `now`; the tick that follows is that deadline's. Lateness
  /// counts from it, plus `suspended`: time that the steady clock itself slept through. Skipped are
  /// the deadlines after it that `now` has reached as well.
  [[nodiscard]] core::LoopReport wake(core::TimePoint now, core::Duration suspended) noexcept;

 private:
  core::TimePoint deadline_;
  core::Duration period_;
};

}  // namespace haptic::server
