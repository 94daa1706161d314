#include "server/owner/loop/loop_clock.hpp"

#include <ctime>

#include <algorithm>

namespace haptic::server {
namespace {

/// A suspend takes longer than this; what is shorter is two clocks not read at the same instant.
constexpr core::Duration kShortestSuspend{std::chrono::milliseconds(1)};
/// Readings at the start, so that at least one of them was not preempted.
constexpr int kFirstReadings = 8;

core::Duration read(clockid_t clock) noexcept {
  timespec t{};
  clock_gettime(clock, &t);
  return std::chrono::seconds(t.tv_sec) + std::chrono::nanoseconds(t.tv_nsec);
}

/// Lower bound of the time the machine has slept since it was started.
core::Duration asleep_at_least() noexcept {
  const core::Duration boot = read(CLOCK_BOOTTIME);
  return boot - read(CLOCK_MONOTONIC);
}

}  // namespace

MonotonicClock::MonotonicClock() noexcept {
  for (int i = 0; i < kFirstReadings; ++i) {
    asleep_so_far_ = std::max(asleep_so_far_, asleep_at_least());
  }
}

Wake MonotonicClock::wait_until(core::TimePoint deadline) noexcept {
  const core::Duration since = deadline.time_since_epoch();
  timespec until{};
  until.tv_sec = std::chrono::duration_cast<std::chrono::seconds>(since).count();
  until.tv_nsec = (since % std::chrono::seconds(1)).count();
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
  return awake();
}

Wake MonotonicClock::wait_for(hw::SampleSignal& samples, core::TimePoint deadline) noexcept {
  const std::optional<core::TimePoint> arrival = samples.wait_until(deadline);
  Wake wake = awake();
  wake.arrival = arrival;
  return wake;
}

Wake MonotonicClock::awake() noexcept {
  Wake wake;
  wake.now = now();
  const core::Duration asleep = asleep_at_least();
  if (asleep - asleep_so_far_ > kShortestSuspend) wake.suspended = asleep - asleep_so_far_;
  asleep_so_far_ = std::max(asleep_so_far_, asleep);
  return wake;
}

core::TimePoint MonotonicClock::now() const noexcept {
  return core::TimePoint(read(CLOCK_MONOTONIC));
}

}  // namespace haptic::server
