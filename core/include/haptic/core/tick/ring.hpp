#pragma once
/// Ring: one writer, one reader, every value in order. The writer never waits: if the reader is
/// too slow the value is dropped and counted.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <type_traits>

namespace haptic::core {

template <typename T>
class Ring {
 public:
  /// `capacity` is rounded up to a power of two. Allocates here and nowhere else.
  explicit Ring(std::size_t capacity)
      : mask_(round_up(capacity) - 1), slots_(std::make_unique<T[]>(mask_ + 2)) {}

  /// Makes what make() returns in its place for the next push(). If the ring is full, the value
  /// goes to a spare slot and is lost. Writer's thread only.
  template <typename Make>
  const T& prepare(const Make& make) noexcept {
    static_assert(std::is_trivially_destructible_v<T>);
    const std::size_t head = head_.load(std::memory_order_relaxed);
    full_ = head - tail_.load(std::memory_order_acquire) > mask_;
    T* const place = &slots_[full_ ? mask_ + 1 : head & mask_];
    return *::new (static_cast<void*>(place)) T(make());
  }
  /// Writer's thread only: hands over what was prepared. False (and counted) if the ring was
  /// full.
  bool push() noexcept {
    if (full_) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    head_.store(head_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
    return true;
  }

  /// Reader's thread only: the oldest value, or nullptr. Stays valid until pop().
  [[nodiscard]] const T* front() const noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) return nullptr;
    return &slots_[tail & mask_];
  }
  /// Reader's thread only, while there is a front(): whether no value came after it yet.
  [[nodiscard]] bool last() const noexcept {
    return tail_.load(std::memory_order_relaxed) + 1 == head_.load(std::memory_order_acquire);
  }
  void pop() noexcept {
    tail_.store(tail_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  /// Values that found the ring full. Any thread.
  [[nodiscard]] std::uint64_t dropped() const noexcept {
    return dropped_.load(std::memory_order_relaxed);
  }
  [[nodiscard]] std::size_t capacity() const noexcept { return mask_ + 1; }

 private:
  static std::size_t round_up(std::size_t n) noexcept {
    std::size_t power = 1;
    while (power < n) power *= 2;
    return power;
  }

  const std::size_t mask_;
  std::unique_ptr<T[]> slots_;  ///< one more than the capacity: of what finds the ring full
  alignas(64) std::atomic<std::size_t> head_{0};
  bool full_{false};  ///< the writer's: when the value was prepared
  alignas(64) std::atomic<std::size_t> tail_{0};
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace haptic::core
