#include "server/rpc/session_stream.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

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
  const double rate = std::clamp(sends ? request.nominal_rate_hz() : states, 1.0, 2000.0);
  return std::chrono::duration_cast<core::Duration>(std::chrono::duration<double>(1.0 / rate));
}

}  // namespace

SessionStream* SessionStream::begin(ServiceContext& context) {
  auto stream = std::make_shared<SessionStream>(context);
  stream->keep_alive();
  stream->StartRead(&stream->incoming_);
  context.streams.add(stream);
  return stream.get();
}

void SessionStream::OnReadDone(bool ok) {
  const core::TimePoint arrival = context_.config.clock({});
  if (!ok) return end(grpc::Status::OK);  // half-closed, or cancelled: then the status goes nowhere
  if (!grpc::SerializationTraits<v1::SessionRequest>::Deserialize(&incoming_, &request_).ok()) {
    return end(to_status(protocol_error("not a SessionRequest")));
  }
  const bool first = std::exchange(first_message_, false);
  if (first != request_.has_open()) {
    return end(to_status(protocol_error(first ? "the first message must be OpenSession"
                                              : "OpenSession must be the first message only")));
  }
  if (request_.has_open()) {
    open(request_.open());
  } else if (request_.has_proxy()) {
    take_sample(request_.proxy(), arrival, Carrier::kGrpc);
  } else {
    return end(to_status(protocol_error("must carry a ProxySample")));
  }
  read_next();
}

void SessionStream::read_next() {
  const std::lock_guard lock(mutex_);
  if (!ended_) StartRead(&incoming_);
}

void SessionStream::open(const v1::OpenSession& request) {
  const auto refuse = [&](const Refusal& refusal) { end(to_status(refusal)); };
  const auto target = context_.device(request.device());
  if (!target) return refuse(target.refusal);
  if (request.role() != v1::ROLE_CONTROLLER && request.role() != v1::ROLE_OBSERVER) {
    return refuse(invalid_field("role", "must be CONTROLLER or OBSERVER"));
  }
  if (request.client_name().empty() || request.client_name().size() > kLongestClientName) {
    return refuse(invalid_field(
        "client_name",
        "has " + std::to_string(request.client_name().size()) + " characters: must have 1..64"));
  }
  if (auto wrong = context_.check_rate("state_rate_hz", request.state_rate_hz())) {
    return refuse(*wrong);
  }
  auto id = context_.registry.admit(SessionRegistry::Kind::kSession, *target.value->device);
  if (!id) return refuse(id.refusal);
  auto events = target.value->device->subscribe(*id.value);
  bool ended = false;
  {
    const std::lock_guard lock(mutex_);
    target_ = *target.value;
    id_ = *id.value;
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

void SessionStream::open_as_controller(const v1::OpenSession& request) {
  target_.device->open_controller(from_proto(request, id_, client_name_), context_.config.clock({}),
                                  [this, weak = weak_from_this()](const Outcome<Lease>& outcome) {
                                    const auto alive = weak.lock();
                                    if (!alive) return;
                                    if (!outcome) return end(to_status(outcome.refusal));
                                    granted(*outcome.value);
                                  });
}

void SessionStream::granted(const Lease& lease) {
  {
    const std::lock_guard lock(mutex_);
    epoch_ = lease.epoch;
  }
  opened(v1::ROLE_CONTROLLER, lease);
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
    if (udp_wanted_) offer_udp(message);
    greeting_due_ = true;
    opened_ = true;
    flush();
  }
  target_.broadcaster->add(shared_from_this(), lease.epoch);
  spdlog::info("session '{}' opened on '{}' as {}", client_name_, target_.device->name(),
               role == v1::ROLE_CONTROLLER ? "controller" : "observer");
  bool ended = false;
  {
    const std::lock_guard lock(mutex_);
    ended = ended_;
  }
  if (ended) target_.broadcaster->remove(this);
}

void SessionStream::take_sample(const v1::ProxySample& sample, core::TimePoint arrival,
                                Carrier carrier) {
  std::uint32_t epoch = 0;
  {
    const std::lock_guard lock(mutex_);
    epoch = epoch_;
  }
  std::string why;
  IngressVerdict verdict = IngressVerdict::kOldEpoch;
  if (epoch == 0) {
    why = "this session does not hold the lease: its samples are not used";
  } else {
    verdict = target_.device->ingress().accept(from_proto(sample, epoch, carrier), arrival, &why);
  }
  const std::lock_guard lock(mutex_);
  ledger_.book(sample.seq(), verdict, std::move(why));
  const bool used = verdict == IngressVerdict::kAccepted || verdict == IngressVerdict::kBacklog;
  if (!used || carrier == std::exchange(samples_by_, carrier)) return;
  tell_transport(carrier == Carrier::kUdp ? "SAMPLES GRPC -> UDP" : "SAMPLES UDP -> GRPC",
                 "the client's choice");
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
  if (!context_.udp) {
    message.set_udp_refused("the scene has no server.udp_listen");
    return;
  }
  const std::size_t largest = largest_state(target_.device->unit().config());
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
  const bool state_due = !greeting_due_ && states_allowed && pace_.due(record.tick);
  const bool by_udp = state_due && udp_ && udp_->send_state(frame.for_datagram());
  if (by_udp || (state_due && !writing_)) pace_.sent(record.tick);
  if (writing_) return by_udp;
  if (state_due && !by_udp) {
    write(frame.for_session());
    return true;
  }
  flush();
  return by_udp;
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
  if (udp_) context_.udp->close(udp_);
  if (!client_name_.empty()) spdlog::info("session '{}' ended", client_name_);
  ResponseStream::OnDone();
}

}  // namespace haptic::server
