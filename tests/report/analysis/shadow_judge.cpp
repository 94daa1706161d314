#include "tests/report/analysis/shadow_judge.hpp"

#include <algorithm>
#include <cmath>

#include "tests/support/percentile.hpp"

namespace haptic::report {

void ShadowJudge::add(const ShadowTick& tick) {
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
  const double off = (tick.felt - tick.shadow).norm();
  const bool bounded = tick.bound.size() > 0;
  if (bounded) {
    const core::VecA most = tick.bound.array() + kRounding;
    ++bounds_;
    broken_ += ((tick.felt - tick.shadow).cwiseAbs().array() > most.array()).any() ? 1 : 0;
  }
  if (!tick.touching) return;
  if (bounded) {
    errors_.push_back(off);
    promised_.push_back(tick.bound.norm());
  }
  ++sums_.ticks;
  squares_ += off * off;
  held_back_ += tick.held_back ? 1 : 0;
  sums_.largest = std::max(sums_.largest, off);
  sums_.peak = std::max(sums_.peak, tick.shadow.norm());
}

ShadowFigures ShadowJudge::figures() const {
  ShadowFigures figures = sums_;
  const double ticks = static_cast<double>(std::max(sums_.ticks, 1L));
  figures.error = std::sqrt(squares_ / ticks);
  figures.held_back = static_cast<double>(held_back_) / ticks;
  figures.bounded = static_cast<double>(errors_.size()) / ticks;
  figures.kept = 1.0 - static_cast<double>(broken_) / static_cast<double>(std::max(bounds_, 1L));
  figures.error_median = test::percentile(errors_, 0.5);
  figures.bound_median = test::percentile(promised_, 0.5);
  return figures;
}

}  // namespace haptic::report
