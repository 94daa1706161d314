#pragma once
/// Values that one process writes and others read, in memory that the readers cannot write: the
/// writer waits for no reader, and a reader that is too slow loses the oldest.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

namespace haptic::server {

/// A value between two stamps: the writer makes the stamp odd, writes, and makes it even again. A
/// reader whose copy began and ended at the same even stamp has a whole value. Copied in words of 8
/// bytes, each of them atomic. Of a T with bytes_used(WORD), which is told the first word of the
/// value, only so many bytes are copied.
template <typename T>
class Stamped {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 8 == 0);
  static constexpr std::size_t kWords = sizeof(T) / 8;

 public:
  /// The writer. `even`: the stamp that the value gets, above the one before.
  void write(const T& value, std::uint64_t even) noexcept {
    const auto* const from = reinterpret_cast<const unsigned char*>(&value);
    stamp_.store(even - 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    std::uint64_t word = 0;
    std::memcpy(&word, from, 8);
    const std::size_t used = words_used(word);
    for (std::size_t i = 0; i < used; ++i) {
      std::memcpy(&word, from + 8 * i, 8);
      words_[i].store(word, std::memory_order_relaxed);
    }
    stamp_.store(even, std::memory_order_release);
  }
  [[nodiscard]] std::uint64_t stamp() const noexcept {
    return stamp_.load(std::memory_order_acquire);
  }
  /// The stamp of the value that was copied; 0: none was written yet; odd: it changed meanwhile,
  /// and `value` is a mixture that must not be read.
  [[nodiscard]] std::uint64_t read(T& value) const noexcept {
    const std::uint64_t before = stamp_.load(std::memory_order_acquire);
    if (before == 0 || before % 2 != 0) return before;
    auto* const to = reinterpret_cast<unsigned char*>(&value);
    const std::size_t used = words_used(words_[0].load(std::memory_order_relaxed));
    for (std::size_t i = 0; i < used; ++i) {
      const std::uint64_t word = words_[i].load(std::memory_order_relaxed);
      std::memcpy(to + 8 * i, &word, 8);
    }
    std::atomic_thread_fence(std::memory_order_acquire);
    return stamp_.load(std::memory_order_relaxed) == before ? before : 1;
  }

 private:
  static std::size_t words_used([[maybe_unused]] std::uint64_t first) noexcept {
    if constexpr (requires { T::bytes_used(first); }) {
      return std::min(kWords, (T::bytes_used(first) + 7) / 8);
    }
    return kWords;
  }

  std::atomic<std::uint64_t> stamp_;
  std::array<std::atomic<std::uint64_t>, kWords> words_;
};

/// The newest of a value.
template <typename T>
class Latest {
 public:
  /// One thread at a time.
  void publish(const T& value) noexcept { slot_.write(value, slot_stamp_ += 2); }
  /// The value as it was written last; `fallback` before the first.
  [[nodiscard]] T value(const T& fallback = T{}) const noexcept {
    T copy = fallback;
    std::uint64_t seen = 0;
    return newer(seen, copy) ? copy : fallback;
  }
  /// True: `copy` is a value that came after the one that `seen` stands for, as `seen` does now.
  /// 0 stands for none.
  [[nodiscard]] bool newer(std::uint64_t& seen, T& copy) const noexcept {
    for (;;) {
      if (slot_.stamp() == seen) return false;
      const std::uint64_t stamp = slot_.read(copy);
      if (stamp == 0) return false;
      if (stamp % 2 != 0) continue;
      return std::exchange(seen, stamp) != stamp;
    }
  }

 private:
  Stamped<T> slot_;
  std::uint64_t slot_stamp_;  ///< the writer's
};

/// Values in order, the last N of them. N is a power of two.
template <typename T, std::size_t N>
class Broadcast {
  static_assert((N & (N - 1)) == 0);

 public:
  static constexpr std::size_t kKept = N;

  /// One thread at a time.
  void publish(const T& value) noexcept {
    const std::uint64_t number = head_.load(std::memory_order_relaxed);
    slots_[number % N].write(value, 2 * (number + 1));
    head_.store(number + 1, std::memory_order_release);
  }
  /// Values written so far.
  [[nodiscard]] std::uint64_t head() const noexcept {
    return head_.load(std::memory_order_acquire);
  }

  /// A reader's place, which is its own.
  struct Cursor {
    std::uint64_t next{0};
  };
  /// Before a reader's first read(): it begins `back` values before the newest, or with the oldest
  /// one.
  [[nodiscard]] Cursor begin(std::uint64_t back) const noexcept {
    const std::uint64_t head = this->head();
    return {head > back ? head - back : 0};
  }
  /// The value at the cursor, which moves on; false: there is none yet.
  [[nodiscard]] bool read(Cursor& cursor, T& value) const noexcept {
    for (;;) {
      const std::uint64_t head = this->head();
      if (cursor.next >= head) return false;
      // The slot after the newest may be in the writer's hands.
      const std::uint64_t oldest = head >= N ? head - N + 1 : 0;
      cursor.next = std::max(cursor.next, oldest);
      if (slots_[cursor.next % N].read(value) != 2 * (cursor.next + 1)) continue;
      ++cursor.next;
      return true;
    }
  }

 private:
  std::atomic<std::uint64_t> head_;
  std::array<Stamped<T>, N> slots_;
};

}  // namespace haptic::server
