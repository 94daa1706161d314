#pragma once
/// Turns the loop's clock into a whole number of equal physics steps, in integers: the same clock
/// gives the same steps, in real and in virtual time.
///
/// A jump of the clock (suspend, debugger) does not run for ever: at most kLongestAdvance of it is
/// simulated, the rest is skipped as if the simulated world had stood still.

#include <algorithm>
#include <chrono>

#include "haptic/core/time.hpp"

namespace haptic::hw {

class Substeps {
 public:
  static constexpr core::Duration kStep{std::chrono::microseconds(100)};  ///< 10 kHz
  static constexpr double kStepSeconds = core::seconds(kStep);
  static constexpr core::Duration kLongestAdvance{std::chrono::milliseconds(100)};

  Substeps() = default;
  explicit Substeps(core::Duration step) noexcept : step_(step) {}

  /// Steps to make so that the physics stands at most one step before `now`. 0 on the first call,
  /// which starts the clock, and if time stands still or goes backwards.
  [[nodiscard]] int advance(core::TimePoint now) noexcept {
    if (!started_) {
      started_ = true;
      last_ = now;
    }
    const core::Duration elapsed = std::max(now - last_, core::Duration::zero());
    last_ = std::max(last_, now);
    rest_ += std::min(elapsed, kLongestAdvance);
    const auto steps = rest_ / step_;
    rest_ -= steps * step_;
    return static_cast<int>(steps);
  }
  /// Time since the last whole step, below the step.
  [[nodiscard]] core::Duration rest() const noexcept { return rest_; }

 private:
  core::Duration step_{kStep};
  bool started_{false};
  core::TimePoint last_{};
  core::Duration rest_{0};
};

}  // namespace haptic::hw
