#pragma once
/// First stage of a tick: its number, its length, and the faults of the loop.

#include <algorithm>

#include "haptic/core/safety/late_bucket.hpp"
#include "haptic/core/tick/tick_record.hpp"

namespace haptic::core {

class Clock {
 public:
  /// `late_fault`: one tick later than this is LOOP_LATE. `bucket_full`: level of LATE_BUCKET_FULL.
  Clock(Duration late_fault, int bucket_full) : late_fault_(late_fault), bucket_(bucket_full) {}

  /// Reads now, period and loop of the input. `ready`: the last tick had a good sample of the
  /// device. Before that the loop may still be warming up, and there is no force to protect: no
  /// fault then.
  [[nodiscard]] Beat step(const TickInput& in, bool ready) noexcept {
    Beat beat;
    beat.tick = ++ticks_;
    beat.dt = ticks_ == 1 ? in.period : std::max(in.now - last_, Duration::zero());
    last_ = in.now;

    bucket_.tick(in.loop.skipped);
    if (!ready) return beat;
    if (in.loop.lateness > late_fault_) beat.faults.set(Fault::kLoopLate);
    if (bucket_.full()) beat.faults.set(Fault::kLateBucketFull);
    return beat;
  }

 private:
  const Duration late_fault_;
  LateBucket bucket_;
  std::uint64_t ticks_{0};
  TimePoint last_{};
};

}  // namespace haptic::core
