#include "hw/sample_signal.hpp"

#include <cerrno>
#include <chrono>
#include <ctime>

namespace haptic::hw {

static_assert(std::atomic<core::TimePoint>::is_always_lock_free);

SampleSignal::SampleSignal() noexcept {
  ::sem_init(&posts_, 0, 0);  // fails for a count beyond SEM_VALUE_MAX only
}

SampleSignal::~SampleSignal() {
  ::sem_destroy(&posts_);
}

// Both sides exchange `pending_`, so that one of the two holds: the post finds it clear and rings,
// or the one who cleared it last has not read yet and sees the sample.

void SampleSignal::post(core::TimePoint arrival) noexcept {
  if (pending_.exchange(true, std::memory_order_acq_rel)) return;
  arrival_.store(arrival, std::memory_order_relaxed);
  ::sem_post(&posts_);
}

core::TimePoint SampleSignal::take() noexcept {
  const core::TimePoint arrival = arrival_.load(std::memory_order_relaxed);
  pending_.exchange(false, std::memory_order_acq_rel);
  return arrival;
}

std::optional<core::TimePoint> SampleSignal::wait_until(core::TimePoint deadline) noexcept {
  const core::Duration since = deadline.time_since_epoch();
  const auto whole = std::chrono::floor<std::chrono::seconds>(since);
  const timespec until{static_cast<time_t>(whole.count()),
                       static_cast<long>((since - whole).count())};
  while (::sem_clockwait(&posts_, CLOCK_MONOTONIC, &until) != 0) {
    if (errno != EINTR) return std::nullopt;
  }
  return take();
}

void SampleSignal::forget() noexcept {
  while (::sem_trywait(&posts_) == 0) static_cast<void>(take());
}

}  // namespace haptic::hw
