#pragma once
/// When a loop ticks that a device's samples pace: with each sample as it comes, and by the timer
/// where none does. The timer has patience: a quarter of a period after a sample was due. While a
/// device is silent its ticks go on a period apart, so that nothing that counts on time stands
/// still.
///
///   earliest   three quarters of a period after the last tick was due: samples that come in a heap,
///              or faster than they should, make no burst; those of a link that carries them in pairs
///              make ticks at the loop's rate
///   latest     a quarter of a period after the next sample is expected: the timer's
///
/// A tick is due when its sample came, or at `latest`; lateness counts from there. As on
/// DeadlineGrid, due times that have passed meanwhile are skipped and counted, never made up for.

#include <optional>

#include "haptic/core/tick/tick_input.hpp"
#include "haptic/core/time.hpp"

namespace haptic::server {

class SampleGrid {
 public:
  /// `first`: when the first sample is expected. period > 0.
  SampleGrid(core::TimePoint first, core::Duration period)
      : previous_(first - period), expected_(first), period_(period) {}

  [[nodiscard]] core::TimePoint earliest() const noexcept { return previous_ + period_ * 3 / 4; }
  [[nodiscard]] core::TimePoint latest() const noexcept { return expected_ + period_ / 4; }

  struct Tick {
    core::LoopReport report{};
    bool by_sample{false};  ///< else by the timer
  };
  /// The wait ended at `now`. `arrival`: of the first sample since the last tick; absent: none
  /// came. `suspended`: what the steady clock slept through, which is lateness too.
  [[nodiscard]] Tick wake(core::TimePoint now, core::Duration suspended,
                          std::optional<core::TimePoint> arrival) noexcept;

 private:
  core::TimePoint previous_;  ///< due time of the last tick, or of the last one skipped after it
  core::TimePoint expected_;
  core::Duration period_;
};

}  // namespace haptic::server
