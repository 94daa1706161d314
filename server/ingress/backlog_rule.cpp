#include <algorithm>

#include "server/ingress/ingress.hpp"

namespace haptic::server {

BacklogRule::BacklogRule(core::Duration nominal_period)
    : interval_(nominal_period / 2), tolerance_(std::max(interval_, kShortestFreshEnd)) {}

BacklogRule::Answer BacklogRule::step(core::TimePoint arrival) noexcept {
  const core::Duration pause = arrival - last_arrival_;
  const bool ran_dry = first_ || pause >= interval_;
  if (first_) {
    // Nothing is known of this stream's past: a burst at its very beginning has no age to fall back
    // to but its own.
    before_burst_ = arrival;
    due_ = arrival;
  } else if (ran_dry) {
    before_burst_ = pause >= 2 * interval_ ? last_arrival_ : born_;
    if (backlog_) due_ = arrival;
    backlog_ = false;
  }
  first_ = false;
  last_arrival_ = arrival;

  // A bucket that twice the nominal rate empties: `due_` runs ahead of the arrivals in a burst.
  if (!backlog_ && arrival < due_ - tolerance_) backlog_ = true;
  if (backlog_) {
    born_ = before_burst_;
  } else {
    due_ = std::max(due_, arrival) + interval_;
    born_ = arrival;
  }
  return {backlog_, born_};
}

}  // namespace haptic::server
