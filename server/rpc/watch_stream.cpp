#include "server/rpc/watch_stream.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>

#include <utility>

#include "server/rpc/convert.hpp"
#include "server/rpc/status.hpp"

namespace haptic::server {

WatchStream* WatchStream::begin(ServiceContext& context, const grpc::ByteBuffer& request) {
  auto stream = std::make_shared<WatchStream>(context);
  stream->self_ = stream;
  stream->open(request);
  context.streams.add(stream);
  return stream.get();
}

void WatchStream::open(const grpc::ByteBuffer& raw) {
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
  target_.broadcaster->add(Broadcaster::Rank::kOther, shared_from_this());
}

bool WatchStream::offer(const core::TickRecord& record, StateFrame& frame, bool states_allowed) {
  const std::lock_guard lock(mutex_);
  if (ended_ || writing_) return false;
  if (states_allowed && pace_.due(record.tick)) {
    pace_.sent(record.tick);
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

void WatchStream::write(grpc::ByteBuffer buffer) {
  writing_ = true;
  outgoing_.Swap(&buffer);
  StartWrite(&outgoing_);
}

void WatchStream::OnWriteDone(bool ok) {
  bool finish = false;
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    finish = ended_;
    if (ok) flush();
  }
  if (finish) {
    Finish(final_status_);
  } else if (!ok) {
    end(grpc::Status::CANCELLED);
  }
}

void WatchStream::OnCancel() {
  end(grpc::Status::CANCELLED);
}

void WatchStream::server_closes() {
  end(to_status({Refusal::Code::kUnavailable, "CLOSING", "the server is shutting down", {}}));
}

void WatchStream::end(const grpc::Status& status) {
  const auto keep = shared_from_this();  // Finish may be followed by OnDone before it returns here
  bool finish = false;
  ServiceContext::Target target;
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    ended_ = true;
    final_status_ = status;
    finish = !writing_;  // else the write's own completion finishes
    target = target_;
  }
  if (target.device != nullptr) {
    target.device->close(id_);
    target.broadcaster->remove(this);
    context_.registry.remove(id_);
  }
  if (finish) Finish(status);
}

void WatchStream::OnDone() {
  const auto last = std::move(self_);
}

}  // namespace haptic::server
