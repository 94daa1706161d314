#include "server/base/bell.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>

namespace haptic::server {

static_assert(std::atomic<std::uint32_t>::is_always_lock_free &&
              sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t));

// Sequential consistency on both sides: either the ringer sees the sleeper's flag and wakes it, or
// the sleeper's futex sees that the number of rings moved and does not sleep.

void Bell::ring() noexcept {
  rings_.fetch_add(1, std::memory_order_seq_cst);
  if (!sleeping_.load(std::memory_order_seq_cst)) return;
  syscall(SYS_futex, &rings_, FUTEX_WAKE_PRIVATE, 1, nullptr, nullptr, 0);
}

void Bell::wait(std::uint32_t heard, const timespec* until) noexcept {
  sleeping_.store(true, std::memory_order_seq_cst);
  // The bit set's variant takes an absolute time.
  syscall(SYS_futex, &rings_, FUTEX_WAIT_BITSET_PRIVATE, heard, until, nullptr,
          FUTEX_BITSET_MATCH_ANY);
  sleeping_.store(false, std::memory_order_seq_cst);
}

void Bell::sleep(std::uint32_t heard) noexcept {
  wait(heard, nullptr);
}

void Bell::meet(std::uint32_t heard, core::TimePoint expected, core::Duration patience) noexcept {
  using Clock = std::chrono::steady_clock;
  const std::chrono::nanoseconds due = expected.time_since_epoch();
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(due);
  const timespec until{static_cast<time_t>(whole.count()),
                       static_cast<long>((due - whole).count())};
  wait(heard, &until);
  const Clock::time_point give_up = Clock::now() + patience;
  while (rings() == heard && Clock::now() < give_up) continue;
}

}  // namespace haptic::server
