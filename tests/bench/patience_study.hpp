#pragma once
/// How long the timer should wait for a board's sample (SampleGrid): links as they are, in virtual time.
/// Whatever is drawn is drawn from the number of the run, so that every patience sees the same
/// samples, and the same figures come out everywhere. The loop wakes at once: what is
/// counted is the rule's doing alone.

#include <optional>
#include <string>
#include <vector>

#include "haptic/core/time.hpp"

namespace haptic::bench {

/// How samples, one a period by the board's crystal, reach the host.
struct SampleLink {
  std::string name{};
  core::Duration delay{std::chrono::microseconds(60)};  ///< from measured to arrived, at least
  core::Duration jitter{0};                             ///< mean of what comes on top, exponential
  core::Duration frame{0};  ///< carried at the multiples of this alone; 0: at once
  double lost{0.0};         ///< share of samples
  double held_up{0.0};      ///< share of samples that come up to a period later
};

/// As they are met; the numbers of frames and pairs are those of USB.
[[nodiscard]] std::vector<SampleLink> usual_links();

/// One row: `runs` of `length` each, in even steps of the phase between samples and timer.
struct PatienceRow {
  double age_p50_us{0.0}, age_p99_us{0.0};  ///< of the newest sample when a tick uses it
  double by_timer_percent{0.0};             ///< of all ticks
  double longest_gap_us{0.0};               ///< between ticks, while samples come
  double shortest_gap_us{0.0};
  double gap_at_silence_us{0.0};  ///< from the last sample's tick to the next one; median of runs
};

/// `patience`: the timer's, a period of 1 ms; absent: the timer begins every tick (DeadlineGrid).
[[nodiscard]] PatienceRow study_patience(const SampleLink& link,
                                         std::optional<core::Duration> patience, int runs = 16,
                                         core::Duration length = std::chrono::seconds(10));

}  // namespace haptic::bench
