#include "server/front/service/session_stream.hpp"

#include <spdlog/spdlog.h>

#include "server/front/session/messages.hpp"
#include "server/front/session/refusals.hpp"

namespace haptic::server {
namespace {

Refusal protocol_error(const std::string& message) {
  return {Refusal::Code::kInvalid, "PROTOCOL", message, "message"};
}

}  // namespace

void SessionStream::begin() {
  const auto self = std::static_pointer_cast<SessionStream>(shared_from_this());
  if (const auto longest = context_.waiting.enter(self, context_.limits.clock({}))) {
    const std::size_t places = context_.waiting.places();
    longest->end_with(limit_reached("TOO_MANY_SESSIONS",
                                    "streams without a session: all " + std::to_string(places) +
                                        " places are taken, and this one waited longest",
                                    places));
  }
  {
    const std::lock_guard lock(mutex_);
    if (!ended_) start_read();
  }
  context_.streams.add(self);
}

bool SessionStream::may_parse(std::size_t bytes) {
  const auto refusal = too_large(bytes);
  if (refusal) end(*refusal);
  return !refusal;
}

void SessionStream::unreadable(const std::string& why) {
  end(protocol_error(why));
}

void SessionStream::received(const v1::SessionRequest& request, std::size_t bytes,
                             core::TimePoint arrival) {
  const bool first = std::exchange(first_message_, false);
  // The headers of a stream mean something only if a session comes of it.
  first ? peer_.account->call(bytes) : peer_.account->message(bytes);
  // Its time was up, or its place was needed, in this very moment: it is being ended.
  if (first && !context_.waiting.leave(*this)) return;
  if (first != request.has_open()) {
    return end(protocol_error(first ? "the first message must be OpenSession"
                                    : "OpenSession must be the first message only"));
  }
  if (request.has_leave()) return end({});
  take(request, arrival);
  const std::lock_guard lock(mutex_);
  if (!ended_) start_read();
}

void SessionStream::take(const v1::SessionRequest& request, core::TimePoint arrival) {
  if (request.has_open()) return open(request.open());
  const auto session = this->session();
  if (request.has_proxy() && session) {
    std::shared_ptr<SessionPath> udp;
    {
      const std::lock_guard lock(mutex_);
      udp = udp_;
    }
    session->take(request.proxy(), arrival, stream_, udp ? udp->clock(arrival) : std::nullopt);
  } else if (request.has_tracker() && session) {
    session->take(request.tracker(), arrival);
  } else {
    end(protocol_error("must carry a ProxySample, TrackerSample or LeaveSession"));
  }
}

void SessionStream::open(const v1::OpenSession& request) {
  const auto device = context_.device(request.device());
  if (!device) return end(device.refusal);
  const auto session =
      std::make_shared<Session>(context_, *device.value, context_.session_settings(stream_));
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    session_ = session;
  }
  session->open(
      request, rights_of(peer_, context_.config),
      [this, request, weak = weak_from_this()](const Outcome<v1::SessionOpened>& outcome) {
        const auto alive = weak.lock();
        if (!alive) return;
        if (!outcome) return end(outcome.refusal);
        opened(*outcome.value, request);
      });
}

void SessionStream::opened(v1::SessionOpened greeting, const v1::OpenSession& request) {
  if (greeting.resumed()) {
    context_.streams.for_each(
        [&](OpenStream& stream) { stream.goes_on_elsewhere(request.resume()); });
  }
  const auto session = this->session();
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    if (request.udp_wanted()) offer_udp(greeting);
    *greeting_.mutable_opened() = std::move(greeting);
    greeting_due_ = true;
    opened_ = true;
    peer_.account->session_opened();
    flush();
  }
  join(*context_.broadcasters[session->device()], session->tenure());
}

void SessionStream::goes_on_elsewhere(const std::string& session_id) {
  {
    const std::lock_guard lock(mutex_);
    if (!opened_ || !(session_->id() == session_id)) return;
  }
  end(Refusal{Refusal::Code::kAborted, "RESUMED", "the session goes on with another stream"});
}

void SessionStream::offer_udp(v1::SessionOpened& message) {
  if (stream_ != Carrier::kGrpc) {
    message.set_udp_refused("its keys go on a stream of gRPC only");
    return;
  }
  if (message.role() == v1::ROLE_TRACKER) {
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
  const DeviceFacts& facts = context_.facts(session_->device());
  const std::size_t largest = facts.largest_state;
  if (largest > wire::kLargestPayload) {
    message.set_udp_refused("a state of this device has up to " + std::to_string(largest) +
                            " bytes: a datagram carries " + std::to_string(wire::kLargestPayload));
    return;
  }
  udp_ = SessionPath::open(*context_.udp, session_, *message.mutable_udp());
}

bool SessionStream::offer(const SerialisedState& state, StateFrame& frame, bool states_allowed) {
  const std::lock_guard lock(mutex_);
  if (ended_ || !opened_) return false;
  session_->used(state);
  // The greeting is the first word of a session, whatever else is waiting.
  const bool due = session_->due(state) && !greeting_due_ && states_allowed;
  const bool by_udp = due && udp_ && udp_->send_state(frame.for_datagram());
  const bool by_stream = due && !by_udp && !writing_;
  if (by_udp || by_stream) session_->sent(state, by_udp ? Carrier::kUdp : stream_);
  if (by_stream) {
    write(frame.for_session());
  } else {
    flush();
  }
  return by_udp || by_stream;
}

void SessionStream::lease_over() {
  const auto self = std::static_pointer_cast<SessionStream>(shared_from_this());
  std::shared_ptr<OpenStream> oldest;
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;  // it may be done(), and would not leave any more
    oldest = context_.former.enter(self, context_.limits.clock({}));
  }
  if (!oldest) return;
  oldest->end_with(limit_reached("TOO_MANY_SESSIONS",
                                 "its lease ended long ago, and its place was needed",
                                 context_.former.places()));
}

void SessionStream::flush() {
  if (writing_ || ended_) return;
  if (greeting_due_) {
    greeting_due_ = false;
    return write(to_outgoing(greeting_));
  }
  if (!opened_) return;
  if (auto keys = udp_ ? udp_->take_keys() : std::nullopt) {
    v1::SessionResponse response;
    *response.mutable_udp() = std::move(*keys);
    return write(to_outgoing(response));
  }
  if (const auto response = session_->next()) write(to_outgoing(*response));
}

void SessionStream::report(const std::string& device, v1::GetLinkStatsResponse& response) {
  const std::lock_guard lock(mutex_);
  if (ended_ || !opened_) return;
  if (!device.empty() && device != context_.facts(session_->device()).name) return;
  v1::SessionLink& message = *response.add_sessions();
  const core::TimePoint now = context_.limits.clock({});
  session_->report(message, udp_ ? udp_->clock(now) : std::nullopt);
  if (udp_) udp_->report(*message.add_transports());
}

std::shared_ptr<Session> SessionStream::session() {
  const std::lock_guard lock(mutex_);
  return session_;
}

void SessionStream::close(Ending ending) {
  if (const auto session = this->session()) session->close(ending == Ending::kLost);
}

void SessionStream::done() {
  static_cast<void>(context_.waiting.leave(*this));
  static_cast<void>(context_.former.leave(*this));
  if (udp_) udp_->close();
  if (session_ && opened_) {
    peer_.account->session_ended();
    spdlog::info("session '{}' ended", session_->client_name());
  }
}

}  // namespace haptic::server
