#pragma once
/// "A new sample can be read": from the thread of a device that has a clock of its own to the
/// real-time loop, which may be waiting for it. A POSIX semaphore underneath: neither side takes a
/// lock or allocates, and posting never waits.
///
///   device's thread   puts the sample where read() finds it, then post()
///   loop              wait_until(), then forget(), then read()
///
/// What is posted while an earlier post has not been taken counts as that one: no backlog of
/// samples can become a burst of ticks.

#include <semaphore.h>

#include <atomic>
#include <optional>

#include "haptic/core/time.hpp"

namespace haptic::hw {

class SampleSignal {
 public:
  SampleSignal() noexcept;
  ~SampleSignal();
  SampleSignal(const SampleSignal&) = delete;
  SampleSignal& operator=(const SampleSignal&) = delete;

  /// One thread, the device's. `arrival`: when the sample reached this host, steady clock.
  void post(core::TimePoint arrival) noexcept;

  /// Loop thread. Waits for a post or until `deadline`; not at all if that has passed. The arrival
  /// of the first sample posted since the last one taken or forgotten; none: none was.
  [[nodiscard]] std::optional<core::TimePoint> wait_until(core::TimePoint deadline) noexcept;

  /// The loop, before it reads: what was posted by now will be read by this very tick.
  void forget() noexcept;

 private:
  core::TimePoint take() noexcept;

  sem_t posts_{};  ///< 0 or 1
  std::atomic<bool> pending_{false};
  std::atomic<core::TimePoint> arrival_{};
};

}  // namespace haptic::hw
