#include "server/rpc/watch_stream.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>

#include <utility>

#include "server/rpc/convert.hpp"
#include "server/rpc/status.hpp"

namespace haptic::server {

WatchStream* WatchStream::begin(ServiceContext& context, const grpc::ByteBuffer& request) {
  auto stream = std::make_shared<WatchStream>(context);
  stream->keep_alive();
  stream->open(request);
  context.streams.add(stream);
  return stream.get();
}

void WatchStream::open(const grpc::ByteBuffer& raw) {
  if (const auto refusal = too_large(raw.Length())) return end(to_status(*refusal));
  v1::WatchRequest request;
  grpc::ByteBuffer bytes(raw);
  if (!grpc::SerializationTraits<v1::WatchRequest>::Deserialize(&bytes, &request).ok()) {
    return end(to_status(invalid_field("message", "is not a WatchRequest")));
  }
  const auto target = context_.device(request.device());
  if (!target) return end(to_status(target.refusal));
  if (auto wrong = context_.check_rate("rate_hz", request.rate_hz())) {
    return end(to_status(*wrong));
  }
  auto id = context_.registry.admit(SessionRegistry::Kind::kWatch, *target.value->device);
  if (!id) return end(to_status(id.refusal));
  {
    const std::lock_guard lock(mutex_);
    target_ = *target.value;
    id_ = *id.value;
    events_ = target_.device->subscribe(id_);
    pace_ = Pace(context_.loop_hz(), request.rate_hz() > 0.0 ? request.rate_hz() : kDefaultRateHz);
  }
  target_.broadcaster->add(shared_from_this());
}

bool WatchStream::offer(const core::TickRecord& record, StateFrame& frame, bool states_allowed) {
  const std::lock_guard lock(mutex_);
  if (ended_ || writing_) return false;
  if (states_allowed && pace_.due(record.beat.tick)) {
    pace_.sent(record.beat.tick);
    write(frame.for_watch(pace_.conflated()));
    return true;
  }
  flush();
  return false;
}

void WatchStream::flush() {
  if (writing_ || ended_) return;
  const auto event = events_->pop();
  if (!event) return;
  v1::WatchResponse response;
  *response.mutable_event() = to_proto(*event);
  response.set_conflated(pace_.conflated());
  write(to_buffer(response));
}

}  // namespace haptic::server
