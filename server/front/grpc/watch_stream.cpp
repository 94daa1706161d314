#include "server/front/grpc/watch_stream.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>

#include "server/front/session/messages.hpp"
#include "server/front/session/refusals.hpp"

namespace haptic::server {

WatchStream* WatchStream::begin(ServiceContext& context, const grpc::ByteBuffer& request,
                                std::shared_ptr<Account> account) {
  auto stream = std::make_shared<WatchStream>(context, std::move(account));
  stream->keep_alive();
  stream->open(request);
  context.streams.add(stream);
  return stream.get();
}

void WatchStream::open(const grpc::ByteBuffer& raw) {
  if (!raw.Valid()) return end({});
  if (const auto refusal = too_large(raw.Length())) return end(*refusal);
  v1::WatchRequest request;
  grpc::ByteBuffer bytes(raw);
  if (!grpc::SerializationTraits<v1::WatchRequest>::Deserialize(&bytes, &request).ok()) {
    return end(invalid_field("message", "is not a WatchRequest"));
  }
  const auto target = context_.device(request.device());
  if (!target) return end(target.refusal);
  if (const auto wrong = check_rate("rate_hz", request.rate_hz(), context_.loop_hz())) {
    return end(*wrong);
  }
  const double rate = request.rate_hz() > 0.0 ? request.rate_hz() : kDefaultRateHz;
  context_.ask(
      {.kind = Request::Kind::kAdmitWatch, .device = static_cast<std::uint32_t>(*target.value)},
      [this, rate, device = *target.value, weak = weak_from_this()](const Answer& answer) {
        const auto alive = weak.lock();
        if (!alive) return;
        if (answer.refusal) return end(*answer.refusal);
        {
          const std::lock_guard lock(mutex_);
          id_ = answer.session_id;
          events_ = context_.subscribe(device);
          pace_ = Pace(context_.loop_hz(), rate);
        }
        join(*context_.broadcasters[device]);
      });
}

bool WatchStream::offer(const SerialisedState& state, StateFrame& frame, bool states_allowed) {
  const std::lock_guard lock(mutex_);
  if (ended_ || writing_) return false;
  if (states_allowed && pace_.due(state.tick)) {
    pace_.sent(state.tick);
    write(frame.for_watch(pace_.conflated()));
    return true;
  }
  flush();
  return false;
}

void WatchStream::flush() {
  if (writing_ || ended_ || !events_) return;
  const auto event = events_->pop();
  if (!event) return;
  v1::WatchResponse response;
  *response.mutable_event() = to_proto(*event);
  response.set_conflated(pace_.conflated());
  write(to_outgoing(response));
}

void WatchStream::close(Ending /*ending*/) {
  SessionId id;
  {
    const std::lock_guard lock(mutex_);
    id = id_;
  }
  if (!id.empty()) context_.tell({.kind = Request::Kind::kClose, .session_id = id});
}

}  // namespace haptic::server
