#include "clock.hpp"

#include <algorithm>

namespace haptic::core {

Beat Clock::step(const TickInput& in, bool ready) noexcept {
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

}  // namespace haptic::core
