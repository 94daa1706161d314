#pragma once
/// Which packet numbers came already: a window of 1024 behind the newest
/// (proto/README.md#the-udp-path).

#include <bitset>
#include <cstdint>

#include "haptic/wire/datagram.hpp"

namespace haptic::wire {

/// Looking and remembering are two steps: only a datagram whose tag verified may move the window.
class ReplayWindow {
 public:
  static constexpr std::uint64_t kSize = 1024;

  /// kNone: it is new; otherwise kDuplicate or kTooOld. Numbers begin with 1; 0 is always too old.
  [[nodiscard]] Rejection check(std::uint64_t number) const noexcept;
  /// `number` is new and genuine.
  void commit(std::uint64_t number) noexcept;
  /// 0: none came yet.
  [[nodiscard]] std::uint64_t newest() const noexcept { return newest_; }

 private:
  std::uint64_t newest_{0};
  std::bitset<kSize> seen_{};  ///< bit n: the number of the window that is n modulo kSize
};

}  // namespace haptic::wire
