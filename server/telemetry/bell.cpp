#include "server/telemetry/bell.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

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

void Bell::sleep(std::uint32_t heard) noexcept {
  sleeping_.store(true, std::memory_order_seq_cst);
  syscall(SYS_futex, &rings_, FUTEX_WAIT_PRIVATE, heard, nullptr, nullptr, 0);
  sleeping_.store(false, std::memory_order_seq_cst);
}

}  // namespace haptic::server
