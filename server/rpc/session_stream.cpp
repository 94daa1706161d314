#include "server/rpc/session_stream.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/owner/state_message.hpp"
#include "server/rpc/convert.hpp"
#include "server/rpc/status.hpp"

namespace haptic::server {
namespace {

constexpr std::size_t kLongestClientName = 64;

Refusal protocol_error(const std::string& message) {
  return {Refusal::Code::kInvalid, "PROTOCOL", message, "message"};
}

/// What the path's silence is measured by: the samples of a controller, the states of an observer.
core::Duration path_period(const v1::OpenSession& request, double loop_hz) {
  const double states = request.state_rate_hz() > 0.0 ? request.state_rate_hz() : loop_hz;
  const bool sends = request.role() == v1::ROLE_CONTROLLER;
  // A rate that is off is refused when the lease is asked for; until then it must not harm.
  const double told = sends ? request.nominal_rate_hz() : states;
  const double rate = std::isnan(told) ? 1.0 : std::clamp(told, 1.0, 2000.0);
  return std::chrono::duration_cast<core::Duration>(std::chrono::duration<double>(1.0 / rate));
}

const char* role_name(v1::Role role) {
  if (role == v1::ROLE_TRACKER) return "tracker";
  return role == v1::ROLE_CONTROLLER ? "controller" : "observer";
}

}  // namespace

SessionStream* SessionStream::begin(ServiceContext& context, Peer peer) {
  auto stream = std::make_shared<SessionStream>(context, std::move(peer));
  stream->keep_alive();
  if (const auto longest = context.waiting.enter(stream, context.config.clock({}))) {
    longest->never_opened({Refusal::Code::kExhausted,
                           "TOO_MANY_SESSIONS",
                           "streams without a session: all " +
                               std::to_string(context.waiting.places()) +
                               " places are taken, and this one waited longest",
                           {},
                           {{"limit", std::to_string(context.waiting.places())}}});
  }
  stream->StartRead(&stream->incoming_);
  context.streams.add(stream);
  return stream.get();
}

void SessionStream::OnReadDone(bool ok) {
  const core::TimePoint arrival = context_.config.clock({});
  // Half-closed, or cancelled: then the status goes nowhere.
  if (!ok) return end(grpc::Status::OK, Ending::kLost);
  if (const auto refusal = too_large(incoming_.Length())) return end(to_status(*refusal));
  if (!grpc::SerializationTraits<v1::SessionRequest>::Deserialize(&incoming_, &request_).ok()) {
    return end(to_status(protocol_error("not a SessionRequest")));
  }
  const bool first = std::exchange(first_message_, false);
  // Its time was up, or its place was needed, in this very moment: it is being ended.
  if (first && !context_.waiting.leave(*this)) return;
  if (first != request_.has_open()) {
    return end(to_status(protocol_error(first ? "the first message must be OpenSession"
                                              : "OpenSession must be the first message only")));
  }
  if (request_.has_open()) {
    open(request_.open());
  } else if (request_.has_proxy()) {
    take_sample(request_.proxy(), arrival, Carrier::kGrpc);
  } else if (request_.has_tracker()) {
    take_pose(request_.tracker(), arrival);
  } else if (request_.has_leave()) {
    return end(grpc::Status::OK);
  } else {
    return end(
        to_status(protocol_error("must carry a ProxySample, TrackerSample or LeaveSession")));
  }
  read_next();
}

void SessionStream::read_next() {
  const std::lock_guard lock(mutex_);
  if (!ended_) StartRead(&incoming_);
}

std::optional<Refusal> SessionStream::refusal_of(const v1::OpenSession& request) const {
  const auto target = context_.device(request.device());
  if (!target) return target.refusal;
  if (request.role() != v1::ROLE_CONTROLLER && request.role() != v1::ROLE_OBSERVER &&
      request.role() != v1::ROLE_TRACKER) {
    return invalid_field("role", "must be CONTROLLER, OBSERVER or TRACKER");
  }
  if (request.role() == v1::ROLE_TRACKER && target.value->device->tracker() == nullptr) {
    return invalid_field("role", "= TRACKER: the scene of device '" + target.value->device->name() +
                                     "' has no tracker");
  }
  if (request.client_name().empty() || request.client_name().size() > kLongestClientName) {
    return invalid_field("client_name", "has " + std::to_string(request.client_name().size()) +
                                            " characters: must have 1..64");
  }
  if (!v1::Priority_IsValid(request.priority())) {
    return invalid_field("priority", "= " + std::to_string(request.priority()) +
                                         ": must be TEST, PRIMARY or OPERATOR");
  }
  const Priority highest = highest_priority(peer_, context_.config);
  if (request.priority() > static_cast<int>(highest)) {
    return Refusal{
        Refusal::Code::kPermission,
        "PRIORITY_DENIED",
        std::string(peer_.names.empty() ? "priority: over TLS without a client certificate"
                                        : "priority: with this client's certificate") +
            " at most " + name(highest) + " is allowed",
        {},
        {{"highest", name(highest)}}};
  }
  return context_.check_rate("state_rate_hz", request.state_rate_hz());
}

void SessionStream::open(const v1::OpenSession& request) {
  const auto refuse = [&](const Refusal& refusal) { end(to_status(refusal)); };
  if (const auto refusal = refusal_of(request)) return refuse(*refusal);
  const auto target = context_.device(request.device());
  DeviceSessions& device = *target.value->device;
  const bool resumes =
      request.role() == v1::ROLE_CONTROLLER && device.would_resume(request.resume());
  auto id = context_.registry.admit(SessionRegistry::Kind::kSession, device, resumes);
  if (!id) return refuse(id.refusal);
  auto events = device.subscribe(*id.value);
  bool ended = false;
  {
    const std::lock_guard lock(mutex_);
    target_ = *target.value;
    id_ = *id.value;
    role_ = request.role();
    client_name_ = sanitised(request.client_name(), kLongestClientName);
    events_ = std::move(events);
    pace_ = Pace(context_.loop_hz(), request.state_rate_hz());
    udp_wanted_ = request.udp_wanted();
    nominal_period_ = path_period(request, context_.loop_hz());
    ended = ended_;
  }
  if (!ended && request.role() == v1::ROLE_OBSERVER) {
    Lease scenes;
    scenes.staleness = target_.device->unit().config().scene.staleness;
    opened(v1::ROLE_OBSERVER, scenes);
  } else if (!ended && request.role() == v1::ROLE_TRACKER) {
    open_as_tracker(request);
  } else if (!ended) {
    open_as_controller(request);
  }
  // A cancel that came in between found nothing to give up yet.
  {
    const std::lock_guard lock(mutex_);
    ended = ended_;
  }
  if (ended) give_up_what_is_held();
}

void SessionStream::open_as_controller(const v1::OpenSession& message) {
  LeaseRequest request = from_proto(message, id_, client_name_);
  // A client that asks for nothing has no more than its certificate allows.
  request.priority = std::min(request.priority, highest_priority(peer_, context_.config));
  target_.device->open_controller(
      request, context_.config.clock({}),
      [this, request, weak = weak_from_this()](const Outcome<Lease>& outcome) {
        const auto alive = weak.lock();
        if (!alive) return;
        if (!outcome) return end(to_status(outcome.refusal));
        granted(*outcome.value, request);
      });
}

void SessionStream::open_as_tracker(const v1::OpenSession& message) {
  const LeaseRequest request = from_proto(message, id_, client_name_);
  const auto limits = target_.device->tracker()->open(request, context_.config.clock({}));
  if (!limits) return end(to_status(limits.refusal));
  Lease none;
  none.staleness = *limits.value;
  opened(v1::ROLE_TRACKER, none);
}

void SessionStream::granted(const Lease& lease, const LeaseRequest& request) {
  {
    const std::lock_guard lock(mutex_);
    epoch_ = lease.epoch;
    grant_ = lease.grant;
  }
  if (!lease.taken_from.empty()) {
    spdlog::warn("{}: '{}' ({}) took the lease from '{}'", target_.device->name(), client_name_,
                 name(request.priority), lease.taken_from);
  }
  if (lease.resumed) {
    context_.streams.for_each(
        [&](OpenStream& stream) { stream.goes_on_elsewhere(request.resume); });
  }
  opened(v1::ROLE_CONTROLLER, lease);
}

void SessionStream::goes_on_elsewhere(const std::string& session_id) {
  {
    const std::lock_guard lock(mutex_);
    if (id_ != session_id) return;
  }
  end(to_status(
      {Refusal::Code::kAborted, "RESUMED", "the session goes on with another stream", {}}));
}

void SessionStream::opened(v1::Role role, const Lease& lease) {
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    v1::SessionOpened& message = *greeting_.mutable_opened();
    message.set_device(target_.device->name());
    message.set_role(role);
    message.set_lease_epoch(lease.epoch);
    set(*message.mutable_lease_timeout(), target_.device->lease_timeout());
    set(*message.mutable_fresh_end(), lease.staleness.fresh_end);
    set(*message.mutable_hold_end(), lease.staleness.hold_end);
    set(*message.mutable_fade_end(), lease.staleness.fade_end);
    message.set_transport(v1::TRANSPORT_GRPC);
    message.set_session_id(id_);
    message.set_resumed(lease.resumed);
    message.set_newest_seq(lease.newest_seq);
    if (udp_wanted_) offer_udp(message);
    greeting_due_ = true;
    opened_ = true;
    flush();
  }
  target_.broadcaster->add(shared_from_this(), lease.grant);
  spdlog::info("session '{}' {} on '{}' as {}{}", client_name_,
               lease.resumed ? "resumed" : "opened", target_.device->name(), role_name(role),
               peer_.names.empty() ? "" : ", certificate of '" + peer_.names.front() + "'");
  bool ended = false;
  {
    const std::lock_guard lock(mutex_);
    ended = ended_;
  }
  if (ended) target_.broadcaster->remove(this);
}

void SessionStream::take_sample(const v1::ProxySample& sample, core::TimePoint arrival,
                                Carrier carrier) {
  const SampleStamp stamp{carrier,
                          sample.ByteSizeLong(),
                          sample.source_time_ns(),
                          sample.device_seq_used(),
                          std::chrono::microseconds(sample.hold_us()),
                          arrival};
  std::uint32_t epoch = 0;
  std::optional<core::TimePoint> left;
  {
    const std::lock_guard lock(mutex_);
    epoch = epoch_;
    left = link_.came(stamp, udp_ ? udp_->clock(arrival) : std::nullopt);
  }
  std::string why;
  IngressVerdict verdict = IngressVerdict::kOldEpoch;
  if (epoch == 0) {
    why = "this session does not hold the lease: its samples are not used";
  } else {
    ProxyCandidate candidate = from_proto(sample, epoch, carrier);
    if (context_.config.age_by_source_time) candidate.left = left;
    verdict = target_.device->ingress().accept(candidate, arrival, &why);
  }
  const std::lock_guard lock(mutex_);
  link_.judged(carrier, verdict);
  ledger_.book(sample.seq(), verdict, std::move(why));
  const bool used = verdict == IngressVerdict::kAccepted || verdict == IngressVerdict::kBacklog;
  if (!used) return;
  samples_by_ = carrier;
  if (carrier == samples_told_by_ || !tell_limit_.allows(arrival)) return;
  samples_told_by_ = carrier;
  tell_transport(carrier == Carrier::kUdp ? "SAMPLES GRPC -> UDP" : "SAMPLES UDP -> GRPC",
                 "the client's choice");
}

void SessionStream::take_pose(const v1::TrackerSample& sample, core::TimePoint arrival) {
  {
    const std::lock_guard lock(mutex_);
    static_cast<void>(
        link_.came({Carrier::kGrpc, sample.ByteSizeLong(), 0, 0, {}, arrival}, std::nullopt));
  }
  std::string why = "this session is no tracker's: its poses are not used";
  IngressVerdict verdict = IngressVerdict::kOldEpoch;
  if (role_ == v1::ROLE_TRACKER) {
    const PoseCandidate pose = from_proto(sample);
    verdict = target_.device->tracker()->accept(id_, pose, arrival, why);
  }
  const std::lock_guard lock(mutex_);
  link_.judged(Carrier::kGrpc, verdict);
  ledger_.book(sample.seq(), verdict, std::move(why));
}

void SessionStream::on_udp_sample(const v1::ProxySample& sample, core::TimePoint arrival) {
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
  }
  take_sample(sample, arrival, Carrier::kUdp);
}

void SessionStream::on_udp_change(wire::PathChange change) {
  const std::lock_guard lock(mutex_);
  if (ended_) return;
  const bool by_udp = udp_->in_use();
  if (by_udp == std::exchange(states_by_udp_, by_udp)) return;
  tell_transport(by_udp ? "STATES GRPC -> UDP" : "STATES UDP -> GRPC", wire::name(change));
}

void SessionStream::on_udp_keys(const wire::PathKeys& keys) {
  const std::lock_guard lock(mutex_);
  new_keys_ = keys;
}

void SessionStream::offer_udp(v1::SessionOpened& message) {
  if (role_ == v1::ROLE_TRACKER) {
    message.set_udp_refused("poses of a tracker go on the stream");
    return;
  }
  if (!context_.udp) {
    message.set_udp_refused("the scene has no server.udp_listen");
    return;
  }
  if (!may_have_keys(peer_, context_.config)) {
    message.set_udp_refused("its keys travel only over TLS, a UNIX socket or loopback");
    return;
  }
  const std::size_t largest = largest_state(target_.device->unit().config(),
                                            target_.device->coupling_softness().has_value());
  if (largest > wire::kLargestPayload) {
    message.set_udp_refused("a state of this device has up to " + std::to_string(largest) +
                            " bytes: a datagram carries " + std::to_string(wire::kLargestPayload));
    return;
  }
  auto self = std::static_pointer_cast<SessionStream>(shared_from_this());
  UdpPort::Opened opened = context_.udp->open(std::weak_ptr<UdpSink>(self), nominal_period_);
  udp_ = std::move(opened.path);
  to_proto(opened.keys, *context_.udp, *message.mutable_udp());
}

void SessionStream::tell_transport(const char* reason, const char* why) {
  spdlog::info("session '{}': {} ({})", client_name_, reason, why);
  events_->push({DeviceEvent::Kind::kTransport, context_.config.clock({}), reason, why,
                 target_.device->unit().state(), epoch_});
}

bool SessionStream::offer(const core::TickRecord& record, StateFrame& frame, bool states_allowed) {
  const std::lock_guard lock(mutex_);
  if (ended_ || !opened_) return false;
  ledger_.look(record.input.now);
  // The greeting is the first word of a session, whatever else is waiting.
  const bool state_due = !greeting_due_ && states_allowed && pace_.due(record.beat.tick);
  const bool by_udp = state_due && udp_ && udp_->send_state(frame.for_datagram());
  if (by_udp || (state_due && !writing_)) pace_.sent(record.beat.tick);
  watch_link(record, by_udp, state_due && !by_udp && !writing_);
  if (writing_) return by_udp;
  if (state_due && !by_udp) {
    write(frame.for_session());
    return true;
  }
  flush();
  return by_udp;
}

void SessionStream::watch_link(const core::TickRecord& record, bool by_udp,
                               bool by_stream) noexcept {
  if (by_udp || by_stream) {
    states_by_ = by_udp ? Carrier::kUdp : Carrier::kGrpc;
    link_.state_sent(record.beat.tick, record.input.now, states_by_);
  }
  const core::CommandSnapshot& command = record.input.command;
  const bool ours = command.lease_held && grant_ != 0 && command.lease_epoch == grant_;
  if (ours && record.proxy.mode != core::ProxyMode::kNone) {
    link_.used(record.input.now, record.proxy.age);
  }
}

void SessionStream::flush() {
  if (writing_ || ended_) return;
  if (greeting_due_) {
    greeting_due_ = false;
    return write(to_buffer(greeting_));
  }
  if (!opened_) return;
  if (new_keys_) {
    v1::SessionResponse response;
    to_proto(*std::exchange(new_keys_, std::nullopt), *context_.udp, *response.mutable_udp());
    return write(to_buffer(response));
  }
  if (auto event = events_->pop()) {
    v1::SessionResponse response;
    *response.mutable_event() = to_proto(*event);
    return write(to_buffer(response));
  }
  if (ledger_.due()) {
    v1::SessionResponse response;
    *response.mutable_ack() = ledger_.tell();
    write(to_buffer(response));
  }
}

void SessionStream::OnDone() {
  static_cast<void>(context_.waiting.leave(*this));
  if (udp_) context_.udp->close(udp_);
  if (!client_name_.empty()) spdlog::info("session '{}' ended", client_name_);
  ResponseStream::OnDone();
}

}  // namespace haptic::server
