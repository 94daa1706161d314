#pragma once
/// Which packet numbers came already: a window of 1024 behind the newest
/// (proto/README.md#the-udp-path).

#include <array>
#include <cstdint>

namespace haptic::wire {

/// Looking and remembering are two steps: only a datagram whose tag verified may move the window.
class ReplayWindow {
 public:
  static constexpr std::uint64_t kSize = 1024;

  enum class Verdict : std::uint8_t { kNew, kDuplicate, kTooOld };

  /// Numbers begin with 1; 0 is too old at any time.
  [[nodiscard]] Verdict check(std::uint64_t number) const noexcept;
  /// `number` was kNew and is genuine.
  void commit(std::uint64_t number) noexcept;
  /// 0: none came yet.
  [[nodiscard]] std::uint64_t newest() const noexcept { return newest_; }

 private:
  static constexpr std::uint64_t kBits = 64;
  [[nodiscard]] static std::size_t word(std::uint64_t number) noexcept {
    return static_cast<std::size_t>((number % kSize) / kBits);
  }
  [[nodiscard]] static std::uint64_t bit(std::uint64_t number) noexcept {
    return std::uint64_t{1} << (number % kBits);
  }

  std::uint64_t newest_{0};
  std::array<std::uint64_t, kSize / kBits> seen_{};
};

}  // namespace haptic::wire
