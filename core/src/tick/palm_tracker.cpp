#include "palm_tracker.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

PalmTracker::PalmTracker(const TrackerSettings& settings, const DeviceLimits& limits) noexcept
    : settings_(settings), limits_(settings.staleness) {
  for (std::size_t i = 0; i < kPalmDofs; ++i) {
    const Eigen::Index dof = settings_.first_dof + static_cast<Eigen::Index>(i);
    lower_[i] = limits.q_lower[dof];
    upper_[i] = limits.q_upper[dof];
    pose_.pose[i] = std::clamp(0.0, lower_[i], upper_[i]);
  }
}

bool PalmTracker::fits(const TrackerSnapshot& sample) const noexcept {
  if (sample.seq == 0) return false;
  for (std::size_t i = 0; i < kPalmDofs; ++i) {
    if (!(sample.pose[i] >= lower_[i] && sample.pose[i] <= upper_[i])) return false;
  }
  return true;
}

void PalmTracker::take(const TrackerSnapshot& sample, TimePoint now,
                       TrackerRecord& record) noexcept {
  if (fits(sample)) {
    pose_ = sample;
    limits_ = tightened(sample.staleness, settings_.staleness);
  }
  const bool any = pose_.seq != 0;
  record.on = true;
  record.first_dof = settings_.first_dof;
  record.seq = pose_.seq;
  record.age = any ? now - pose_.born : Duration::zero();
  record.level = any ? staleness(record.age, pose_.valid_for, limits_) : Staleness::kLost;
  record.ladder = any ? ladder(record.age, limits_) : 0.0;
  record.hold_end = limits_.hold_end;
}

void PalmTracker::place(VecQ& q) const noexcept {
  for (std::size_t i = 0; i < kPalmDofs; ++i) {
    q[settings_.first_dof + static_cast<Eigen::Index>(i)] = pose_.pose[i];
  }
}

}  // namespace haptic::core
