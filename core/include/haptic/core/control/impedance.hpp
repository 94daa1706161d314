#pragma once
/// The rendering impedance Z_q = {K, B} on the actuated DoFs: tau_a = K S(q* - q) - B q_a_dot
/// (paper Eq. (6), (7); damping is an addition to the paper and only dissipates).

#include "haptic/core/time.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

/// Low-pass of first order, backward Euler. `now` came `dt` s after the value that gave `before`;
/// it lags a ramp by exactly `lag` s, however samples are spaced. 0: `now` itself.
[[nodiscard]] constexpr double low_passed(double before, double now, double dt,
                                          double lag) noexcept {
  return lag > 0.0 ? before + (now - before) * (dt / (dt + lag)) : now;
}

/// Rate of the actuated DoFs from the device's own time stamps: the difference of the two newest
/// samples, low-passed (core/METHOD.md#noise-of-the-sensors).
class Rate {
 public:
  Rate(int n_a, Duration lag) : lag_(seconds(lag)), value_(VecA::Zero(n_a)) {}
  /// A new sample of q_a measured at `time`. Samples more than `longest` apart, or not in order,
  /// give rate 0, from which the next one goes on.
  void update(const VecA& q_a, TimePoint time, Duration longest) noexcept;
  /// Samples stopped coming: the rate is unknown and taken as 0.
  void forget() noexcept;
  [[nodiscard]] const VecA& value() const noexcept { return value_; }

 private:
  const double lag_;
  VecA value_;
  VecA last_{};
  TimePoint last_time_{};
  bool has_last_{false};
};

}  // namespace haptic::core
