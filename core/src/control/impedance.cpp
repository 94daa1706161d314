#include "haptic/core/control/impedance.hpp"

namespace haptic::core {

void Rate::update(const VecA& q_a, TimePoint time, Duration longest) noexcept {
  const Duration dt = time - last_time_;
  if (has_last_ && dt > Duration::zero() && dt <= longest) {
    const double dt_s = seconds(dt);
    for (Eigen::Index i = 0; i < q_a.size(); ++i) {
      value_[i] = low_passed(value_[i], (q_a[i] - last_[i]) / dt_s, dt_s, lag_);
    }
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
