#include "server/front/session/session.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/front/session/link_report.hpp"
#include "server/front/session/messages.hpp"
#include "server/front/session/refusals.hpp"

namespace haptic::server {
namespace {

constexpr std::size_t kLongestClientName = 64;

/// Period of a controller's samples, or of an observer's states: the measure of a datagram path's
/// silence. A rate that is off is refused when the lease is asked for; until then it must not harm.
core::Duration period_of(const v1::OpenSession& request, double loop_hz) {
  const double states = request.state_rate_hz() > 0.0 ? request.state_rate_hz() : loop_hz;
  const double told = request.role() == v1::ROLE_CONTROLLER ? request.nominal_rate_hz() : states;
  const double rate = std::isnan(told) ? 1.0 : std::clamp(told, 1.0, 2000.0);
  return std::chrono::duration_cast<core::Duration>(std::chrono::duration<double>(1.0 / rate));
}

const char* role_name(v1::Role role) {
  if (role == v1::ROLE_TRACKER) return "tracker";
  return role == v1::ROLE_CONTROLLER ? "controller" : "observer";
}

}  // namespace

Session::Session(Front& front, std::size_t device, const SessionSettings& settings)
    : front_(front), device_(device), settings_(settings) {}

Session::~Session() {
  if (ticket_ != 0) front_.forget(ticket_);
}

std::optional<Refusal> Session::refusal_of(const v1::OpenSession& request,
                                           const Rights& rights) const {
  if (request.role() != v1::ROLE_CONTROLLER && request.role() != v1::ROLE_OBSERVER &&
      request.role() != v1::ROLE_TRACKER) {
    return invalid_field("role", "must be CONTROLLER, OBSERVER or TRACKER");
  }
  if (request.client_name().empty() || request.client_name().size() > kLongestClientName) {
    return invalid_field("client_name", "has " + std::to_string(request.client_name().size()) +
                                            " characters: must have 1..64");
  }
  if (!rights.control && request.role() != v1::ROLE_OBSERVER) return observes_only();
  if (!v1::Priority_IsValid(request.priority())) {
    return invalid_field("priority", "= " + std::to_string(request.priority()) +
                                         ": must be TEST, PRIMARY or OPERATOR");
  }
  if (request.priority() > static_cast<int>(rights.highest)) {
    return Refusal{
        Refusal::Code::kPermission,
        "PRIORITY_DENIED",
        "priority: " + rights.because + " at most " + name(rights.highest) + " is allowed",
        {},
        {{{"highest", name(rights.highest)}}}};
  }
  return check_rate("state_rate_hz", request.state_rate_hz(), settings_.loop_hz);
}

void Session::open(const v1::OpenSession& request, const Rights& rights, const Opened& opened) {
  if (const auto refusal = refusal_of(request, rights)) return opened(*refusal);
  {
    const std::lock_guard lock(mutex_);
    role_ = request.role();
    client_name_ = sanitised(request.client_name(), kLongestClientName);
    pace_ = Pace(settings_.loop_hz, request.state_rate_hz());
    nominal_period_ = period_of(request, settings_.loop_hz);
  }
  Request admission;
  admission.kind = request.role() == v1::ROLE_OBSERVER ? Request::Kind::kAdmitObserver
                                                       : Request::Kind::kAdmitSession;
  admission.device = static_cast<std::uint32_t>(device_);
  if (request.role() == v1::ROLE_CONTROLLER) admission.session_id = session_id(request.resume());
  front_.ask(admission, [self = shared_from_this(), request, rights, opened](const Answer& answer) {
    if (answer.refusal) return opened(*answer.refusal);
    self->admitted(request, rights, answer.session_id, opened);
  });
}

void Session::admitted(const v1::OpenSession& request, const Rights& rights, const SessionId& id,
                       const Opened& opened) {
  auto events =
      front_.subscribe(device_, core::TimePoint(core::Duration(request.events_after_ns())));
  bool closed = false, lost = false;
  {
    const std::lock_guard lock(mutex_);
    id_ = id;
    ticket_ = front_.ticket(weak_from_this());
    events_ = std::move(events);
    closed = closed_;
    lost = lost_;
  }
  // close() found nothing to give up yet.
  if (closed) return tell_owner_of_end(id, lost);
  if (request.role() == v1::ROLE_OBSERVER) {
    Lease none;
    none.staleness = front_.facts(device_).staleness;
    return granted(rights, {}, none, opened);
  }
  Request wish;
  wish.kind = request.role() == v1::ROLE_TRACKER ? Request::Kind::kTrack : Request::Kind::kOpen;
  wish.session_id = id;
  wish.time = settings_.clock({});
  wish.lease = from_proto(request, client_name_);
  // A client that asks for no priority has no more than it may have.
  wish.lease.priority = std::min(wish.lease.priority, rights.highest);
  front_.ask(wish,
             [self = shared_from_this(), rights, lease = wish.lease, opened](const Answer& answer) {
               if (answer.refusal) return opened(*answer.refusal);
               self->granted(rights, lease, answer.lease, opened);
             });
}

void Session::granted(const Rights& rights, const LeaseRequest& request, const Lease& lease,
                      const Opened& opened) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    epoch_ = lease.epoch;
    tenure_ = lease.tenure;
  }
  const std::string& device = front_.facts(device_).name;
  if (!lease.taken_from.empty()) {
    spdlog::warn("{}: '{}' ({}) took the lease from '{}'", device, client_name_,
                 name(request.priority), lease.taken_from.view());
  }
  spdlog::info("session '{}' {} on '{}' as {}{}", client_name_,
               lease.resumed ? "resumed" : "opened", device, role_name(role_),
               rights.bearer.empty() ? "" : ", " + rights.bearer);
  opened(greeting(lease));
}

v1::SessionOpened Session::greeting(const Lease& lease) const {
  const DeviceFacts& facts = front_.facts(device_);
  v1::SessionOpened message;
  message.set_device(facts.name);
  message.set_role(role_);
  message.set_lease_epoch(lease.epoch);
  set(*message.mutable_lease_timeout(), facts.lease_timeout);
  set(*message.mutable_fresh_end(), lease.staleness.fresh_end);
  set(*message.mutable_hold_end(), lease.staleness.hold_end);
  set(*message.mutable_fade_end(), lease.staleness.fade_end);
  message.set_transport(static_cast<v1::Transport>(settings_.stream));
  message.set_session_id(id_.str());
  message.set_resumed(lease.resumed);
  message.set_newest_seq(lease.newest_seq);
  return message;
}

void Session::close(bool lost) {
  SessionId id;
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(closed_, true)) return;
    lost_ = lost;
    id = id_;
  }
  if (!id.empty()) tell_owner_of_end(id, lost);
}

void Session::tell_owner_of_end(const SessionId& id, bool lost) {
  front_.tell({.kind = lost ? Request::Kind::kLose : Request::Kind::kClose, .session_id = id});
}

void Session::take(const v1::ProxySample& message, core::TimePoint arrival, Carrier carrier,
                   const ClockEstimate& path_clock) {
  ProxySample sample;
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    sample.epoch = epoch_;
    sample.ticket = ticket_;
    const auto left = link_.came(
        {carrier, message.ByteSizeLong(), message.source_time_ns(), message.device_seq_used(),
         std::chrono::microseconds(message.hold_us()), arrival},
        path_clock);
    if (settings_.age_by_source_time) sample.left = left;
  }
  if (sample.epoch == 0) {
    return on_judged({0,
                      message.seq(),
                      carrier,
                      {IngressVerdict::kOldEpoch,
                       "this session does not hold the lease: its samples are not used"}});
  }
  sample.device = static_cast<std::uint32_t>(device_);
  sample.carrier = carrier;
  sample.arrival = arrival;
  from_proto(message, sample);
  front_.owner().post(sample);
}

void Session::take(const v1::TrackerSample& message, core::TimePoint arrival) {
  PoseSample pose = from_proto(message);
  {
    const std::lock_guard lock(mutex_);
    static_cast<void>(
        link_.came({settings_.stream, message.ByteSizeLong(), 0, 0, {}, arrival}, std::nullopt));
    pose.session_id = id_;
    pose.ticket = ticket_;
  }
  if (role_ != v1::ROLE_TRACKER) {
    return on_judged(
        {0,
         message.seq(),
         settings_.stream,
         {IngressVerdict::kOldEpoch, "this session is no tracker's: its poses are not used"}});
  }
  pose.device = static_cast<std::uint32_t>(device_);
  pose.arrival = arrival;
  front_.owner().post(pose);
}

void Session::on_judged(const Judged& judged) {
  const Carrier carrier = judged.carrier;
  {
    const std::lock_guard lock(mutex_);
    link_.judged(carrier, judged.verdict.verdict);
    ledger_.book(judged.seq, judged.verdict);
    if (!judged.verdict.used() || role_ == v1::ROLE_TRACKER) return;
    samples_by_ = carrier;
    if (carrier == samples_told_by_ || !tell_limit_.allows(settings_.clock({}))) return;
    samples_told_by_ = carrier;
  }
  tell_transport(carrier == Carrier::kUdp ? "SAMPLES GRPC -> UDP" : "SAMPLES UDP -> GRPC",
                 "the client's choice");
}

bool Session::due(const SerialisedState& state) {
  const std::lock_guard lock(mutex_);
  ledger_.look(state.now);
  return pace_.due(state.tick);
}

void Session::sent(const SerialisedState& state, Carrier carrier) {
  const std::lock_guard lock(mutex_);
  pace_.sent(state.tick);
  states_by_ = carrier;
  link_.state_sent(state.tick, state.now, carrier);
}

void Session::used(const SerialisedState& state) {
  const std::lock_guard lock(mutex_);
  const bool ours = state.lease_held && tenure_ != 0 && state.tenure == tenure_;
  if (ours && state.proxy_used) link_.used(state.now, state.proxy_age);
}

std::optional<v1::SessionResponse> Session::next() {
  v1::SessionResponse response;
  const std::lock_guard lock(mutex_);
  if (!events_) return std::nullopt;
  if (const auto event = events_->pop()) {
    *response.mutable_event() = to_proto(*event);
  } else if (ledger_.due()) {
    *response.mutable_ack() = ledger_.tell();
  } else {
    return std::nullopt;
  }
  return response;
}

void Session::tell_transport(const char* reason, const char* why) {
  const core::LifecycleState state = front_.owner().status(device_).state;
  const std::lock_guard lock(mutex_);
  if (closed_ || !events_) return;
  spdlog::info("session '{}': {} ({})", client_name_, reason, why);
  events_->push({DeviceEvent::Kind::kTransport, settings_.clock({}), reason, why, state, epoch_});
}

void Session::report(v1::SessionLink& message, const ClockEstimate& path_clock) const {
  const bool holds_lease = front_.owner().status(device_).holder == id_;
  const std::lock_guard lock(mutex_);
  message.set_device(front_.facts(device_).name);
  message.set_client_name(client_name_);
  message.set_role(role_);
  message.set_lease_epoch(epoch_);
  message.set_holds_lease(holds_lease);
  if (link_.figures(settings_.stream).samples + link_.figures(Carrier::kUdp).samples > 0) {
    message.set_samples_by(static_cast<v1::Transport>(samples_by_));
  }
  message.set_states_by(static_cast<v1::Transport>(states_by_));
  report_link(link_, settings_.stream, path_clock, holds_lease, settings_.clock({}), message);
}

CarrierFigures Session::figures(Carrier carrier) const {
  const std::lock_guard lock(mutex_);
  return link_.figures(carrier);
}

}  // namespace haptic::server
