#include "haptic/core/safety/cell_watch.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

const char* check(const CellRatings& r) noexcept {
  if (!(r.range > 0.0)) return "range must be > 0";
  if (!(r.rate > 0.0)) return "rate must be > 0";
  if (!(r.swing > 0.0)) return "swing must be > 0";
  if (!(r.friction > 0.0)) return "friction must be > 0";
  if (r.damping && !(std::isfinite(*r.damping) && *r.damping >= 0.0)) return "damping must be >= 0";
  return nullptr;
}

FaultSet CellWatch::step(const CellView& view) noexcept {
  FaultSet doubts;
  if (!(std::abs(view.reading) <= ratings_.range)) doubts.set(Fault::kForceOutOfRange);
  if (view.driven) {
    if (too_fast(view)) doubts.set(Fault::kForceTooFast);
    if (stuck(view)) doubts.set(Fault::kForceStuck);
    if (disagrees(view)) doubts.set(Fault::kForceDisagrees);
  } else {
    began_at_ = view.command;
    same_ = 0;
    excess_ = 0.0;
    followed_ = view.q;
  }
  if (view.fresh) last_ = view.reading;
  return doubts;
}

/// Eq. (29), its rate. A force may vanish at once: the finger slips out.
bool CellWatch::too_fast(const CellView& view) const noexcept {
  if (!view.fresh || !last_) return false;
  const double most = ratings_.rate * view.interval;
  return !(view.reading <= std::max(0.0, *last_) + most &&
           view.reading >= std::min(0.0, *last_) - most);
}

/// Readings are counted from where the command has gone too far: the cell answers only after the
/// link and the drive.
bool CellWatch::stuck(const CellView& view) noexcept {
  if (!view.fresh) return same_ >= kSame;
  if (!last_ || view.reading != *last_) {
    began_at_ = view.command;
    same_ = 0;
  } else if (same_ > 0 || std::abs(view.command - began_at_) > ratings_.swing) {
    same_ = std::min(same_ + 1, kSame);
  }
  return same_ >= kSame;
}

/// Eq. (30). The average of the rate is the distance from the average before, over the time.
bool CellWatch::disagrees(const CellView& view) noexcept {
  const double share = std::min(1.0, view.dt / kTime);
  excess_ += share * (view.command - view.reading - excess_);
  const double moved = view.q - followed_;
  followed_ += share * moved;
  const double braked = ratings_.damping.value_or(0.0) * moved / kTime;
  const bool above = excess_ > ratings_.friction + std::max(0.0, braked);
  const bool below = excess_ < -ratings_.friction + std::min(0.0, braked);
  if (!std::isfinite(excess_)) return std::isfinite(ratings_.friction);
  return (above && !view.at_upper) || (below && !view.at_lower);
}

}  // namespace haptic::core
