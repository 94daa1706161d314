#include "haptic/core/control/impedance.hpp"

namespace haptic::core {

void Rate::update(const VecA& q_a, TimePoint time, Duration longest) noexcept {
  const Duration dt = time - last_time_;
  if (has_last_ && dt > Duration::zero() && dt <= longest) {
    value_ = (q_a - last_) / seconds(dt);
  } else {
    value_.setZero();
  }
  last_ = q_a;
  last_time_ = time;
  has_last_ = true;
}

void Rate::forget() noexcept {
  value_.setZero();
  has_last_ = false;
}

}  // namespace haptic::core
