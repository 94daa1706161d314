#pragma once
/// Mailbox: one writer, one reader, the newest value wins, neither ever waits.
///
/// Three slots. The writer owns `write`, the reader owns `read`, the third lies on the `table`
/// between them. publish() swaps `write`, once it is filled, with the table, marking it new; take()
/// swaps `read` with the table if what lies there is new. There is no "full" and no "empty": before
/// the first publish the reader sees the value the mailbox was built with.

#include <array>
#include <atomic>
#include <cstdint>

namespace haptic::core {

template <typename T>
class Mailbox {
 public:
  explicit Mailbox(const T& initial = T{}) { slots_.fill(initial); }
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;

  /// An old slot. Fill it, then publish(). Writer's thread only, or under the writers' own mutex.
  [[nodiscard]] T& draft() noexcept { return slots_[write_]; }
  void publish(const T& value) noexcept {
    draft() = value;
    publish();
  }
  void publish() noexcept {
    write_ = static_cast<std::uint8_t>(
        table_.exchange(static_cast<std::uint8_t>(write_ | kNew), std::memory_order_acq_rel) &
        kIndex);
  }

  /// Reader's thread only. True if the value is newer than that of the previous take().
  bool take() noexcept {
    if ((table_.load(std::memory_order_relaxed) & kNew) == 0) return false;
    read_ = static_cast<std::uint8_t>(table_.exchange(read_, std::memory_order_acq_rel) & kIndex);
    return true;
  }
  /// Reader's thread only: the value last taken.
  [[nodiscard]] const T& value() const noexcept { return slots_[read_]; }

 private:
  static constexpr std::uint8_t kIndex = 3;
  static constexpr std::uint8_t kNew = 4;

  std::array<T, 3> slots_{};
  alignas(64) std::atomic<std::uint8_t> table_{1};
  alignas(64) std::uint8_t write_{0};
  alignas(64) std::uint8_t read_{2};
};

}  // namespace haptic::core
