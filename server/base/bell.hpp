#pragma once
/// A bell between two threads: the real-time one rings, the other sleeps until it rings.
///
/// A futex and not std::atomic::notify: libstdc++'s keeps its waiters in a table shared with
/// the whole process, and a ring costs a system call whether or not a thread sleeps.

#include <atomic>
#include <cstdint>
#include <ctime>

#include "haptic/core/time.hpp"

namespace haptic::server {

class Bell {
 public:
  /// Any thread, real-time safe. One system call if the other thread sleeps, else two atomic
  /// operations.
  void ring() noexcept;

  /// One thread. The number of rings so far, for sleep().
  [[nodiscard]] std::uint32_t rings() const noexcept {
    return rings_.load(std::memory_order_seq_cst);
  }
  /// The same thread: until the bell has rung more often than `heard` (or a spurious wake-up).
  void sleep(std::uint32_t heard) noexcept;
  /// The same thread, if the next ring is due soon after `expected` (steady clock): sleeps by the
  /// clock until then and stays awake for `patience`, so that the ring needs no wake-up.
  /// Returns at the ring, or without one when patience ends: sleep() then.
  void meet(std::uint32_t heard, core::TimePoint expected, core::Duration patience) noexcept;

 private:
  void wait(std::uint32_t heard, const timespec* until) noexcept;

  std::atomic<std::uint32_t> rings_{0};
  std::atomic<bool> sleeping_{false};
};

}  // namespace haptic::server
