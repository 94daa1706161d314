/// DeviceSessions: who has the lease, from the first asking to its end.

#include <utility>

#include "server/session/device_sessions.hpp"

namespace haptic::server {
namespace {

/// How long a newcomer waits for its predecessor's fade, which takes fade_end - hold_end: 1 s at most
/// (render_scene.cpp), and 80 ms by default.
constexpr core::Duration kNewcomerPatience = std::chrono::milliseconds(1500);

Refusal held_by(const std::string& device, const std::string& holder, Priority priority) {
  return {Refusal::Code::kExists,
          "LEASE_HELD",
          "device '" + device + "' is controlled by '" + holder + "'",
          {},
          {{"device", device}, {"holder", holder}, {"priority", name(priority)}}};
}

}  // namespace

void DeviceSessions::close(const std::string& session_id, Ending ending) {
  if (tracker_) tracker_->close(session_id);
  Closures closures;
  {
    const std::lock_guard lock(mutex_);
    queues_.erase(session_id);
    const bool waits = newcomer_ && newcomer_->request.session_id == session_id;
    if (waits) newcomer_.reset();
    if (lease_.held_by(session_id)) {
      if (ending == Ending::kLost && !waits && lease_.resumable() && !command_.closing) {
        lease_.detach();
        tell_lease("LEASE_DETACHED", "'" + lease_.client_name() + "' lost its stream");
      } else {
        tell_lease("LEASE_ENDED", "'" + lease_.client_name() + "' left");
        end_lease(closures);
      }
    }
  }
  PendingRequests::run(closures);
}

void DeviceSessions::open_controller(const LeaseRequest& request, core::TimePoint now,
                                     const LeaseAnswer& answer) {
  Closures closures;
  {
    const std::lock_guard lock(mutex_);
    const Outcome<core::StalenessLimits> limits =
        lease_staleness(request, unit_.config().scene.staleness, rules_.fresh_end);
    std::optional<Refusal> refusal;
    if (command_.closing) {
      refusal =
          Refusal{Refusal::Code::kUnavailable, "CLOSING", "the server is shutting down", {}, {}};
    } else if (!limits) {
      refusal = limits.refusal;
    } else if (resumes(request.resume)) {
      resume_lease(request, now, answer, closures);
    } else if (newcomer_ && request.priority <= newcomer_->request.priority) {
      refusal = held_by(name(), newcomer_->request.client_name, newcomer_->request.priority);
    } else if (!lease_.yields_to(request.priority)) {
      refusal = held_by(name(), lease_.client_name(), lease_.priority());
    } else {
      wait_for_lease({request, *limits.value, answer, now + kNewcomerPatience, {}, false}, now,
                     closures);
    }
    if (refusal) closures.push_back([answer, refusal = *refusal] { answer(refusal); });
  }
  PendingRequests::run(closures);
}

bool DeviceSessions::resumes(const std::string& former) const noexcept {
  return !former.empty() && !newcomer_ && lease_.resumable() && lease_.held_by(former);
}

/// Age, gain, settings and limits stay as they are: to the loop nothing happens at all. The former
/// stream, if it still stands (its end may be known to the client only), goes on as an observer's.
void DeviceSessions::resume_lease(const LeaseRequest& request, core::TimePoint now,
                                  const LeaseAnswer& answer, Closures& closures) {
  if (pending_.lease_ended(lease_.session_id(), closures)) {
    // Whoever was told that Engage failed must not feel it act.
    ++command_.release_id;
    post();
  }
  const std::uint32_t epoch = lease_.resume(request, now, ingress_.last_accepted());
  resumes_ = lease_.resumes();
  ingress_.renew_lease(epoch);
  tell_lease("LEASE_RESUMED", "'" + request.client_name + "' is back");
  Lease lease{epoch, settings_.staleness, lease_.grants(), true, ingress_.newest_seq(), {}};
  closures.push_back([answer, lease = std::move(lease)] { answer(lease); });
}

/// The newcomer has the lease when g = 0. Of a holder that must yield the writes are refused from this
/// moment on: the newcomer's epoch stands at once, q* is frozen, its force fades out from the gain it
/// has.
void DeviceSessions::wait_for_lease(Newcomer newcomer, core::TimePoint now, Closures& closures) {
  if (newcomer_) {
    const LeaseRequest& by = newcomer.request;
    closures.push_back([call = std::move(newcomer_->answer),
                        why = held_by(name(), by.client_name, by.priority)] { call(why); });
  }
  if (lease_.held()) {
    newcomer.taken_from = newcomer_ ? newcomer_->taken_from : lease_.client_name();
    tell_lease("LEASE_PREEMPTED", "'" + lease_.client_name() + "' lost the device to '" +
                                      newcomer.request.client_name + "' (" +
                                      server::name(newcomer.request.priority) + ")");
    end_lease(closures);
    lease_.grant(newcomer.request, now);
    newcomer.granted = true;
    command_.lease_epoch = lease_.grants();
    command_.lease_held = true;
    post();
  }
  newcomer_ = std::move(newcomer);
  if (!force_is_on()) grant_newcomer(now, closures);
}

void DeviceSessions::grant_newcomer(core::TimePoint now, Closures& closures) {
  Newcomer newcomer = std::move(*newcomer_);
  newcomer_.reset();
  if (newcomer.granted) {
    lease_.restart_clock(now);
  } else {
    lease_.grant(newcomer.request, now);
  }
  core::RenderSettings settings = unit_.config().scene;
  settings.staleness = newcomer.staleness;
  publish_settings(settings);
  settings_due_ = false;
  ingress_.begin_lease(lease_.epoch(), newcomer.request.nominal_rate_hz,
                       newcomer.staleness.hold_end, lease_.grants());
  command_.lease_epoch = lease_.grants();
  command_.lease_held = true;
  post();
  tell_lease("LEASE_GRANTED", "to '" + newcomer.request.client_name + "'");
  Lease lease{lease_.epoch(), newcomer.staleness, lease_.grants(), false, 0, newcomer.taken_from};
  closures.push_back(
      [call = std::move(newcomer.answer), lease = std::move(lease)] { call(lease); });
}

void DeviceSessions::look_after_lease(const core::TickRecord& record, Closures& closures) {
  const core::TimePoint now = record.input.now;
  const bool promised = newcomer_ && newcomer_->granted;  // its clock starts when it is granted
  if (!promised && lease_.expired(now, ingress_.last_accepted())) {
    tell_everyone({DeviceEvent::Kind::kLeaseExpired, now, "LEASE_EXPIRED",
                   "'" + lease_.client_name() +
                       (lease_.detached()
                            ? "' did not come back within the lease time"
                            : "' sent no valid sample for the lease time and is an observer now"),
                   record.life.state, lease_.epoch()});
    end_lease(closures);
  }
  if (!force_is_on()) {
    if (newcomer_) {
      grant_newcomer(now, closures);
    } else if (settings_due_) {
      restore_scene_settings();
    }
  } else if (newcomer_ && now >= newcomer_->gives_up) {
    closures.push_back([call = std::move(newcomer_->answer)] {
      call(Refusal{Refusal::Code::kUnavailable,
                   "NO_ANSWER",
                   "the force of the previous controller did not fade out in time",
                   {},
                   {}});
    });
    if (newcomer_->granted) end_lease(closures);
    newcomer_.reset();
  }
}

void DeviceSessions::end_lease(Closures& closures) {
  const std::string session_id = lease_.session_id();
  lease_.end();
  ingress_.end_lease();
  command_.lease_held = false;
  post();
  settings_due_ = true;
  static_cast<void>(pending_.lease_ended(session_id, closures));  // the end of a lease releases
}

void DeviceSessions::tell_lease(const char* reason, std::string message) {
  tell_everyone({DeviceEvent::Kind::kLease, newest_.input.now, reason, std::move(message),
                 newest_.life.state, lease_.epoch()});
}

}  // namespace haptic::server
