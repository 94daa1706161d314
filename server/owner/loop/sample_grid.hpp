#pragma once
/// When the loop ticks: by the timer alone, on a fixed grid first + n period; or with each sample
/// of a device as it comes, and by the timer if none does. Then the timer has patience: a quarter
/// of a period after a sample was due. While a device is silent its ticks go on a period apart, so
/// that nothing that counts on time stands still.
///
///   earliest   a period less the patience after the last tick was due; after a tick of the timer's
///              that is when a sample comes that is on time again. Samples that come in a heap, or
///              faster than they should, make no burst; those of a link that carries them in pairs
///              make ticks at the loop's rate
///   latest     the patience after the next sample is expected: the timer's
///
/// A quarter: less leaves ticks to the timer that a link's jitter would have brought a sample, more
/// lets ticks be further apart, and older samples be used, if one is lost (server/README.md).
///
/// A tick is due when its sample came, or at `latest`; lateness counts from there. A tick that
/// comes late never moves the timer's grid, and due times that have passed meanwhile are skipped
/// and counted, never made up for.

#include <optional>

#include "haptic/core/tick/tick_input.hpp"
#include "haptic/core/time.hpp"

namespace haptic::server {

class SampleGrid {
 public:
  /// `first`: when the first sample is expected, or the timer's first tick. period > 0;
  /// 0 <= patience <= period / 2, 0 for the timer alone.
  SampleGrid(core::TimePoint first, core::Duration period, core::Duration patience)
      : previous_(first - period), expected_(first), period_(period), patience_(patience) {}

  [[nodiscard]] core::TimePoint earliest() const noexcept {
    return previous_ + period_ - patience_;
  }
  [[nodiscard]] core::TimePoint latest() const noexcept { return expected_ + patience_; }

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
  core::Duration patience_;
};

}  // namespace haptic::server
