#include "haptic/core/control/impedance.hpp"

#include <algorithm>

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

double DampingGain::step(bool wanted, Duration dt) noexcept {
  const double elapsed = seconds(dt);
  return value_ = wanted ? std::min(1.0, value_ + elapsed / seconds(kRise))
                         : std::max(0.0, value_ - elapsed / seconds(kFall));
}

}  // namespace haptic::core
