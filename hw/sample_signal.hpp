#pragma once
/// Tells the real-time loop that a new sample can be read. The thread of a device with its own
/// clock posts, the loop may wait. Built on a POSIX semaphore: neither side takes a lock or
/// allocates, and posting never waits.
///
///   device's thread   puts the sample where read() finds it, then post()
///   loop              wait_until(), then forget(), then read()
///
/// Several posts before the loop takes one count as one, so that a backlog of samples does not
/// become a burst of ticks.

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

  /// Loop thread. Waits for a post, at most until `deadline`. Returns the arrival of the first
  /// sample that was posted since the last one taken or forgotten; empty if none was posted.
  [[nodiscard]] std::optional<core::TimePoint> wait_until(core::TimePoint deadline) noexcept;

  /// Loop thread, before it reads: drops earlier posts, because this tick reads their samples.
  void forget() noexcept;

 private:
  core::TimePoint take() noexcept;

  sem_t posts_{};  ///< 0 or 1
  std::atomic<bool> pending_{false};
  std::atomic<core::TimePoint> arrival_{};
};

}  // namespace haptic::hw
