/// DeviceSessions: who has the lease, from the first request to its end.

#include <utility>

#include "server/owner/rights/device_sessions.hpp"
#include "server/owner/rights/settings_policy.hpp"

namespace haptic::server {
namespace {

/// How long a newcomer waits for its predecessor's fade, which takes fade_end - hold_end: 80 ms by
/// default, and at most 1 s in any scene.
constexpr core::Duration kNewcomerPatience = std::chrono::milliseconds(1500);

Refusal held_by(const std::string& device, const ClientName& holder, Priority priority) {
  return {Refusal::Code::kExists,
          "LEASE_HELD",
          "device '" + device + "' is controlled by '" + holder.str() + "'",
          {},
          {{{"device", device}, {"holder", holder}, {"priority", name(priority)}}}};
}

std::string quoted(const ClientName& name) {
  return "'" + name.str() + "'";
}

}  // namespace

void DeviceSessions::close(const Request& request) {
  const SessionId& session = request.session_id;
  if (tracker_) tracker_->close(session);
  const bool waits = newcomer_ && newcomer_->request.session_id == session;
  // Every request gets its answer: the front keeps its call until then.
  if (waits) {
    refuse_newcomer({Refusal::Code::kAborted, "SESSION_ENDED",
                     "its session ended while it waited for the lease"});
  }
  if (!lease_.held_by(session)) return;
  const bool lost = request.kind == Request::Kind::kLose;
  if (lost && !waits && lease_.resumable && !command_.closing) {
    lease_.detached = true;
    tell_lease("LEASE_DETACHED", quoted(lease_.client_name) + " lost its stream");
  } else {
    tell_lease("LEASE_ENDED", quoted(lease_.client_name) + " left");
    end_lease();
  }
}

void DeviceSessions::open(const Request& asked) {
  LeaseRequest request = asked.lease;
  request.session_id = asked.session_id;
  const Outcome<core::StalenessLimits> limits =
      lease_staleness(request, unit_.config().scene.staleness, rules_.fresh_end);
  const std::string& device = unit_.name();
  if (command_.closing) {
    answer(asked.id, kClosing);
  } else if (!limits) {
    answer(asked.id, limits.refusal);
  } else if (resumes(request.resume)) {
    resume_lease(request, asked.time, asked.id);
  } else if (newcomer_ && request.priority <= newcomer_->request.priority) {
    answer(asked.id, held_by(device, newcomer_->request.client_name, newcomer_->request.priority));
  } else if (!lease_.yields_to(request.priority)) {
    answer(asked.id, held_by(device, lease_.client_name, lease_.priority));
  } else {
    wait_for_lease({asked.id, request, *limits.value, asked.time + kNewcomerPatience, {}, false},
                   asked.time);
  }
}

void DeviceSessions::open_tracker(const Request& asked) {
  LeaseRequest request = asked.lease;
  request.session_id = asked.session_id;
  if (!tracker_) {
    return answer(
        asked.id,
        {Refusal::Code::kInvalid, "INVALID_ARGUMENT",
         "role = TRACKER: the scene of device '" + unit_.name() + "' has no tracker", "role"});
  }
  const auto limits = tracker_->open(request, asked.time);
  if (!limits) return answer(asked.id, limits.refusal);
  answer(asked.id).lease.staleness = *limits.value;
}

bool DeviceSessions::would_resume(const SessionId& resume) const noexcept {
  return !command_.closing && resumes(resume);
}

bool DeviceSessions::resumes(const SessionId& former) const noexcept {
  return !former.empty() && !newcomer_ && lease_.resumable && lease_.held_by(former);
}

/// Age, gain, settings and limits stay as they are: the loop notices nothing. The former stream, if
/// it still stands (its end may be known to the client only), goes on as an observer's.
void DeviceSessions::resume_lease(const LeaseRequest& request, core::TimePoint now,
                                  std::uint64_t id) {
  if (pending_.lease_ended(lease_.session_id, out_.answers)) take_engage_back();
  const std::uint32_t epoch = lease_.resume(request, now, ingress_.last_accepted());
  ingress_.renew_lease(epoch);
  tell_lease("LEASE_RESUMED", quoted(request.client_name) + " is back");
  answer(id).lease = {epoch, settings_.staleness, lease_.tenure, true, ingress_.newest_seq(), {}};
}

/// The newcomer has the lease at g = 0. If it takes the lease from a holder, the holder's samples
/// are refused from now on: the newcomer's epoch stands at once, q* is frozen, and the holder's
/// force fades out from the gain it has.
void DeviceSessions::wait_for_lease(Newcomer newcomer, core::TimePoint now) {
  const LeaseRequest& by = newcomer.request;
  ClientName taken_from = lease_.client_name;
  if (newcomer_) {
    taken_from = newcomer_->taken_from;
    refuse_newcomer(held_by(unit_.name(), by.client_name, by.priority));
  }
  if (lease_.has_holder) {
    newcomer.taken_from = taken_from;
    tell_lease("LEASE_PREEMPTED", quoted(lease_.client_name) + " lost the device to " +
                                      quoted(by.client_name) + " (" + server::name(by.priority) +
                                      "): once that has left, engage again");
    end_lease();
    lease_.grant(by, now);
    newcomer.granted = true;
    command_.tenure = lease_.tenure;
    command_.lease_held = true;
    post();
  }
  newcomer_ = newcomer;
  if (!force_is_on()) grant_newcomer(now);
}

void DeviceSessions::grant_newcomer(core::TimePoint now) {
  const Newcomer newcomer = *std::exchange(newcomer_, std::nullopt);
  if (newcomer.granted) {
    lease_.opened = now;
  } else {
    lease_.grant(newcomer.request, now);
  }
  core::RenderSettings settings = unit_.config().scene;
  settings.staleness = newcomer.staleness;
  publish_settings(settings);
  settings_due_ = false;
  ingress_.begin_lease(lease_.epoch(), newcomer.request.nominal_rate_hz,
                       newcomer.staleness.hold_end, lease_.tenure);
  command_.tenure = lease_.tenure;
  command_.lease_held = true;
  post();
  tell_lease("LEASE_GRANTED", "to " + quoted(newcomer.request.client_name));
  answer(newcomer.id).lease = {lease_.epoch(),     newcomer.staleness, lease_.tenure, false, 0,
                               newcomer.taken_from};
}

void DeviceSessions::refuse_newcomer(const Refusal& why) {
  answer(newcomer_->id, why);
  newcomer_.reset();
}

void DeviceSessions::look_after_lease(const core::TickRecord& record) {
  const core::TimePoint now = record.input.now;
  const bool promised = newcomer_ && newcomer_->granted;  // its clock starts when it is granted
  if (!promised && lease_.expired(now, ingress_.last_accepted())) {
    tell(DeviceEvent::Kind::kLeaseExpired, "LEASE_EXPIRED",
         quoted(lease_.client_name) +
             (lease_.detached ? " did not come back within the lease time"
                              : " sent no valid sample for the lease time and is an observer now"));
    end_lease();
  }
  if (!force_is_on()) {
    if (newcomer_) {
      grant_newcomer(now);
    } else if (settings_due_) {
      publish_settings(unit_.config().scene);
      settings_due_ = false;
    }
  } else if (newcomer_ && now >= newcomer_->gives_up) {
    if (newcomer_->granted) end_lease();
    refuse_newcomer({Refusal::Code::kUnavailable, "NO_ANSWER",
                     "the force of the previous controller did not fade out in time"});
  }
}

void DeviceSessions::end_lease() {
  const SessionId session_id = lease_.session_id;
  lease_.end();
  ingress_.end_lease();
  command_.lease_held = false;
  post();
  settings_due_ = true;
  static_cast<void>(pending_.lease_ended(session_id, out_.answers));  // the end releases
  pending_.forget_engage();
}

void DeviceSessions::tell_lease(const char* reason, const std::string& message) {
  tell(DeviceEvent::Kind::kLease, reason, message);
}

}  // namespace haptic::server
