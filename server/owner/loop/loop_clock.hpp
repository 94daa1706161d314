#pragma once
/// The loop's clock: what it waits on and reads. Linux's in the server, a scripted one in tests.

#include <optional>

#include "haptic/core/time.hpp"
#include "hw/sample_signal.hpp"

namespace haptic::server {

struct Wake {
  core::TimePoint now{};
  /// How long the machine was suspended since the last wake-up. CLOCK_MONOTONIC stands still then,
  /// so that nothing else would tell.
  core::Duration suspended{0};
  /// Arrival of the sample that was waited for; absent: none came by the deadline, or none was
  /// waited for.
  std::optional<core::TimePoint> arrival{};
};

class LoopClock {
 public:
  virtual ~LoopClock() = default;
  LoopClock(const LoopClock&) = delete;
  LoopClock& operator=(const LoopClock&) = delete;

  /// Real-time thread. Returns at `deadline` or later; at once if it has passed.
  virtual Wake wait_until(core::TimePoint deadline) noexcept = 0;
  /// Real-time thread. Returns when `samples` were posted, and at `deadline` or later if not.
  virtual Wake wait_for(hw::SampleSignal& samples, core::TimePoint deadline) noexcept = 0;
  [[nodiscard]] virtual core::TimePoint now() const noexcept = 0;

 protected:
  LoopClock() = default;
};

/// clock_nanosleep on CLOCK_MONOTONIC (libstdc++'s steady_clock) to absolute deadlines; samples by
/// their semaphore, on the same clock.
class MonotonicClock final : public LoopClock {
 public:
  MonotonicClock() noexcept;
  Wake wait_until(core::TimePoint deadline) noexcept override;
  Wake wait_for(hw::SampleSignal& samples, core::TimePoint deadline) noexcept override;
  [[nodiscard]] core::TimePoint now() const noexcept override;

 private:
  Wake awake() noexcept;
  /// CLOCK_BOOTTIME, which runs on in a suspend, minus CLOCK_MONOTONIC: the largest lower bound
  /// seen. A preemption between the two readings only makes a bound smaller, so it is never taken
  /// for a suspend.
  core::Duration asleep_so_far_{core::Duration::min()};
};

}  // namespace haptic::server
