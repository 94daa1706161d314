#pragma once
/// The rendering impedance Z_q = {K, B} on the actuated DoFs: tau_a = K S(q* - q) - B q_a_dot
/// (paper Eq. (6), (7); damping is an addition to the paper and only dissipates).

#include "haptic/core/time.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

/// Rate of the actuated DoFs from the device's own time stamps: the difference of the two newest
/// samples. No filter: a filter's lag turns damping into activity.
class Rate {
 public:
  explicit Rate(int n_a) : value_(VecA::Zero(n_a)) {}
  /// A new sample of q_a measured at `time`. Samples more than `longest` apart, or not in order,
  /// give rate 0.
  void update(const VecA& q_a, TimePoint time, Duration longest) noexcept;
  /// Samples stopped coming: the rate is unknown and taken as 0.
  void forget() noexcept;
  [[nodiscard]] const VecA& value() const noexcept { return value_; }

 private:
  VecA value_;
  VecA last_{};
  TimePoint last_time_{};
  bool has_last_{false};
};

}  // namespace haptic::core
