#pragma once
/// Samples from the front to the owner, in memory that the front can write at any time and in any
/// way. The owner believes nothing in it: it copies a slot first and checks the copy.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace haptic::server {

/// The last N values that the front wrote; a writer that is faster than the reader overwrites the
/// oldest. N is a power of two. If T has told_bytes(), only these are written and copied.
template <typename T, std::size_t N>
class Inbox {
  static_assert(std::is_trivially_copyable_v<T> && (N & (N - 1)) == 0);

 public:
  static constexpr std::size_t kSlots = N;

  /// The front's side, one thread at a time.
  void push(const T& value) noexcept {
    const std::uint64_t number = head_.load(std::memory_order_relaxed);
    copy_told(slots_[number % N], value);
    head_.store(number + 1, std::memory_order_release);
  }

  /// The owner's place; not in shared memory.
  struct Cursor {
    std::uint64_t next{0};
  };
  /// The owner's side: take() has nothing to do.
  [[nodiscard]] bool taken(std::uint64_t next) const noexcept {
    return head_.load(std::memory_order_acquire) == next;
  }
  /// The owner's side: copies the value at the cursor and moves on; false: there is none. Returns
  /// at most N values until the writer writes again, whatever it says. A value that is written
  /// while it is copied may be a mixture of two: so the copy is checked like any other.
  [[nodiscard]] bool take(Cursor& cursor, T& copy) const noexcept {
    const std::uint64_t head = head_.load(std::memory_order_acquire);
    if (head == cursor.next) return false;
    // Also if the number went backwards, which no honest writer does.
    if (head - cursor.next > N) {
      cursor.next = head < N ? 0 : head - N;
      if (head == cursor.next) return false;
    }
    copy_told(copy, slots_[cursor.next % N]);
    ++cursor.next;
    return true;
  }

 private:
  /// Slots are cold: a sample with one plane costs a sixteenth of one with 32. How much there is to
  /// copy, the copy of the head says, which no writer changes.
  static void copy_told(T& to, const T& from) noexcept {
    const auto bytes = [&](std::size_t begin, std::size_t end) {
      std::memcpy(reinterpret_cast<std::byte*>(&to) + begin,
                  reinterpret_cast<const std::byte*>(&from) + begin, end - begin);
    };
    if constexpr (requires { to.told_bytes(); }) {
      bytes(0, T::head_bytes());
      bytes(T::head_bytes(), to.told_bytes());
    } else {
      bytes(0, sizeof(T));
    }
  }

  std::atomic<std::uint64_t> head_;
  std::array<T, N> slots_;
};

}  // namespace haptic::server
