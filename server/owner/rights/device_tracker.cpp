#include "server/owner/rights/device_tracker.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/model/rigid_pose.hpp"
#include "server/base/figures.hpp"
#include "server/owner/ingress/refused.hpp"
#include "server/owner/rights/settings_policy.hpp"

namespace haptic::server {
namespace {

Verdict check_orientation(const std::array<double, 4>& orientation) {
  double squares = 0.0;
  for (std::size_t i = 0; i < orientation.size(); ++i) {
    if (!std::isfinite(orientation[i])) {
      return refused(IngressVerdict::kNotFinite, "orientation[{}] = {:.6g}: must be finite", i,
                     orientation[i]);
    }
    squares += orientation[i] * orientation[i];
  }
  const double norm = std::sqrt(squares);
  if (std::abs(norm - 1.0) <= DeviceTracker::kNormTolerance) return {};
  return refused(IngressVerdict::kOutOfBounds,
                 "orientation has norm {:.6g}: must be a unit quaternion, within 0.01 of 1", norm);
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
  const std::string holder = client_name_.str();
  const auto held = [&](const std::string& message) {
    return Refusal{Refusal::Code::kExists, "TRACKER_HELD", message, {}, {{{"holder", holder}}}};
  };
  if (!session_id_.empty() && now - heard_ < silence_) {
    return held("the palm is tracked by '" + holder + "'");
  }
  if (newest_.seq != 0 && now - newest_.born < newest_.staleness.fade_end) {
    return held("the last pose of '" + holder + "' is " + measured_ms(now - newest_.born) +
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

void DeviceTracker::close(const SessionId& session_id) {
  if (session_id_ == session_id) session_id_ = {};
}

ClientName DeviceTracker::client_name() const {
  return session_id_.empty() ? ClientName{} : client_name_;
}

Verdict DeviceTracker::accept(const PoseSample& pose) {
  if (session_id_.empty() || !(session_id_ == pose.session_id)) {
    return refused(IngressVerdict::kOldEpoch,
                   "this session does not track the palm any more: its poses are not used");
  }
  Verdict verdict = check(pose);
  if (!verdict.used()) return verdict;
  const BacklogRule::Answer age = backlog_.step(pose.arrival);
  heard_ = pose.arrival;
  seq_ = newest_.seq = pose.seq;
  newest_.born = age.born;
  newest_.valid_for = newest_.staleness.fresh_end;
  if (pose.valid_for > core::Duration::zero()) {
    newest_.valid_for = std::min(newest_.valid_for, pose.valid_for);
  }
  const auto& o = pose.orientation.value;
  const Eigen::Vector3d turn = core::rotation_vector({o[0], o[1], o[2], o[3]});
  for (std::size_t i = 0; i < 3; ++i) {
    newest_.pose[i] = flushed(pose.position.value[i]);
    newest_.pose[i + 3] = flushed(turn[static_cast<Eigen::Index>(i)]);
  }
  mailbox_.publish(newest_);
  if (age.backlog) verdict.verdict = IngressVerdict::kBacklog;
  return verdict;
}

Verdict DeviceTracker::check(const PoseSample& pose) const {
  if (pose.position.count != 3) {
    return refused(IngressVerdict::kWrongSize, "position has {} values: must have 3, x, y, z in m",
                   pose.position.count);
  }
  if (pose.orientation.count != 4) {
    return refused(IngressVerdict::kWrongSize, "orientation has {} values: must have 4, x, y, z, w",
                   pose.orientation.count);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const double value = pose.position.value[i];
    if (!std::isfinite(value)) {
      return refused(IngressVerdict::kNotFinite, "position[{}] = {:.6g}: must be finite", i, value);
    }
    if (value >= lower_[i] && value <= upper_[i]) continue;
    return refused(IngressVerdict::kOutOfBounds,
                   "position[{}] = {:.6g}: must lie within {:.6g} to {:.6g} m", i, value, lower_[i],
                   upper_[i]);
  }
  const Verdict turn = check_orientation(pose.orientation.value);
  if (!turn.used()) return turn;
  if (pose.seq <= seq_) {
    return refused(IngressVerdict::kOldSequence, "seq = {}: must be above {}", pose.seq, seq_);
  }
  return {};
}

}  // namespace haptic::server
