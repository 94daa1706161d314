#include "tests/report/analysis/shadow_judge.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::report {

void ShadowJudge::add(const ShadowTick& tick) noexcept {
  const double elastic = tick.elastic.norm();
  if (tick.clearance > kFar && !tick.touching) sums_.drag = std::max(sums_.drag, elastic);
  if (tick.touching && !touched_) {
    ++sums_.contacts;
    late_ = 0;
  }
  touched_ = tick.touching;
  if (!tick.touching) late_ = -1;
  if (late_ >= 0) {
    if (elastic > 0.0) {
      late_ = -1;
    } else {
      sums_.onset = std::max(sums_.onset, ++late_);
    }
  }
  if (!tick.touching) return;
  const double off = (tick.felt - tick.shadow).norm();
  ++sums_.ticks;
  squares_ += off * off;
  held_back_ += tick.held_back ? 1 : 0;
  sums_.largest = std::max(sums_.largest, off);
  sums_.peak = std::max(sums_.peak, tick.shadow.norm());
}

ShadowFigures ShadowJudge::figures() const noexcept {
  ShadowFigures figures = sums_;
  const double ticks = static_cast<double>(std::max(sums_.ticks, 1L));
  figures.error = std::sqrt(squares_ / ticks);
  figures.held_back = static_cast<double>(held_back_) / ticks;
  return figures;
}

}  // namespace haptic::report
