#include "server/session/device_tracker.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/model/rigid_pose.hpp"
#include "server/base/figures.hpp"
#include "server/session/settings_policy.hpp"

namespace haptic::server {
namespace {

std::string entry(const char* field, int index, double value) {
  return std::string(field) + "[" + std::to_string(index) + "] = " + figure(value);
}

IngressVerdict check_orientation(const double* orientation, std::string& why) {
  double squares = 0.0;
  for (int i = 0; i < 4; ++i) {
    if (!std::isfinite(orientation[i])) {
      why = entry("orientation", i, orientation[i]) + ": must be finite";
      return IngressVerdict::kNotFinite;
    }
    squares += orientation[i] * orientation[i];
  }
  const double norm = std::sqrt(squares);
  if (std::abs(norm - 1.0) <= DeviceTracker::kNormTolerance) return IngressVerdict::kAccepted;
  why = "orientation has norm " + figure(norm) + ": must be a unit quaternion, within 0.01 of 1";
  return IngressVerdict::kOutOfBounds;
}

}  // namespace

DeviceTracker::DeviceTracker(core::Mailbox<core::TrackerSnapshot>& mailbox,
                             const core::PipelineConfig& config,
                             std::optional<core::Duration> fresh_bound, core::Duration silence)
    : mailbox_(mailbox),
      scene_(config.tracker->staleness),
      fresh_bound_(fresh_bound),
      silence_(silence) {
  for (std::size_t i = 0; i < lower_.size(); ++i) {
    const Eigen::Index dof = config.tracker->first_dof + static_cast<Eigen::Index>(i);
    lower_[i] = config.device.q_lower[dof];
    upper_[i] = config.device.q_upper[dof];
  }
}

Outcome<core::StalenessLimits> DeviceTracker::open(const LeaseRequest& request,
                                                   core::TimePoint now) {
  Outcome<core::StalenessLimits> limits = lease_staleness(request, scene_, fresh_bound_);
  if (!limits) return limits;
  const std::lock_guard lock(mutex_);
  const auto held = [&](const std::string& message) {
    return Refusal{Refusal::Code::kExists, "TRACKER_HELD", message, {}, {{"holder", client_name_}}};
  };
  if (!session_id_.empty() && now - heard_ < silence_) {
    return held("the palm is tracked by '" + client_name_ + "'");
  }
  if (newest_.seq != 0 && now - newest_.born < newest_.staleness.fade_end) {
    return held("the last pose of '" + client_name_ + "' is " + measured_ms(now - newest_.born) +
                " old and still counts: try again");
  }
  session_id_ = request.session_id;
  client_name_ = request.client_name;
  heard_ = now;
  seq_ = 0;
  backlog_ = BacklogRule(std::chrono::duration_cast<core::Duration>(
      std::chrono::duration<double>(1.0 / request.nominal_rate_hz)));
  newest_.staleness = *limits.value;
  return limits;
}

void DeviceTracker::close(const std::string& session_id) {
  const std::lock_guard lock(mutex_);
  if (session_id_ == session_id) session_id_.clear();
}

std::string DeviceTracker::client_name() const {
  const std::lock_guard lock(mutex_);
  return session_id_.empty() ? std::string() : client_name_;
}

IngressVerdict DeviceTracker::accept(const std::string& session_id, const PoseCandidate& candidate,
                                     core::TimePoint arrival, std::string& why) {
  const std::lock_guard lock(mutex_);
  if (session_id_.empty() || session_id_ != session_id) {
    why = "this session does not track the palm any more: its poses are not used";
    return IngressVerdict::kOldEpoch;
  }
  const IngressVerdict verdict = check(candidate, why);
  if (verdict != IngressVerdict::kAccepted) return verdict;
  const BacklogRule::Answer age = backlog_.step(arrival);
  heard_ = arrival;
  seq_ = newest_.seq = candidate.seq;
  newest_.born = age.born;
  newest_.valid_for = newest_.staleness.fresh_end;
  if (candidate.valid_for > core::Duration::zero()) {
    newest_.valid_for = std::min(newest_.valid_for, candidate.valid_for);
  }
  const double* const o = candidate.orientation;
  const Eigen::Vector3d turn = core::rotation_vector({o[0], o[1], o[2], o[3]});
  for (std::size_t i = 0; i < 3; ++i) {
    newest_.pose[i] = candidate.position[i];
    newest_.pose[i + 3] = turn[static_cast<Eigen::Index>(i)];
  }
  mailbox_.publish(newest_);
  return age.backlog ? IngressVerdict::kBacklog : IngressVerdict::kAccepted;
}

IngressVerdict DeviceTracker::check(const PoseCandidate& candidate, std::string& why) const {
  if (candidate.position_size != 3) {
    why = "position has " + std::to_string(candidate.position_size) +
          " values: must have 3, x, y, z in m";
    return IngressVerdict::kWrongSize;
  }
  if (candidate.orientation_size != 4) {
    why = "orientation has " + std::to_string(candidate.orientation_size) +
          " values: must have 4, x, y, z, w";
    return IngressVerdict::kWrongSize;
  }
  for (int i = 0; i < 3; ++i) {
    const double value = candidate.position[i];
    if (!std::isfinite(value)) {
      why = entry("position", i, value) + ": must be finite";
      return IngressVerdict::kNotFinite;
    }
    const auto axis = static_cast<std::size_t>(i);
    if (value >= lower_[axis] && value <= upper_[axis]) continue;
    why = entry("position", i, value) + ": must lie within " + figure(lower_[axis]) + " to " +
          figure(upper_[axis]) + " m";
    return IngressVerdict::kOutOfBounds;
  }
  const IngressVerdict turn = check_orientation(candidate.orientation, why);
  if (turn != IngressVerdict::kAccepted) return turn;
  if (candidate.seq <= seq_) {
    why = "seq = " + std::to_string(candidate.seq) + ": must be above " + std::to_string(seq_);
    return IngressVerdict::kOldSequence;
  }
  return IngressVerdict::kAccepted;
}

}  // namespace haptic::server
