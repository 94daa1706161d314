#pragma once
/// When a stream is due its next state, and how many it missed for being busy.

#include <algorithm>
#include <cstdint>

namespace haptic::server {

/// Every `stride`-th tick is due, fractions included: 30 Hz of 1 kHz is a stride of 33.3.
class Pace {
 public:
  /// `rate_hz` 0: every tick.
  Pace(double loop_hz, double rate_hz)
      : stride_(rate_hz > 0.0 ? std::max(1.0, loop_hz / rate_hz) : 1.0) {}

  [[nodiscard]] bool due(std::uint64_t tick) const noexcept {
    return !started_ || static_cast<double>(tick) >= next_;
  }
  /// A state of `tick` was sent.
  void sent(std::uint64_t tick) noexcept {
    const auto at = static_cast<double>(tick);
    if (!started_) {
      started_ = true;
      next_ = at + stride_;
      return;
    }
    // Ticks that were due since, but the one that is sent now, were never sent.
    const auto missed = static_cast<std::uint64_t>(std::max(0.0, at - next_) / stride_);
    conflated_ += missed;
    next_ += stride_ * static_cast<double>(missed + 1);
  }
  /// States that were due but not sent, in total.
  [[nodiscard]] std::uint64_t conflated() const noexcept { return conflated_; }

 private:
  double stride_;
  double next_{0.0};
  std::uint64_t conflated_{0};
  bool started_{false};
};

}  // namespace haptic::server
