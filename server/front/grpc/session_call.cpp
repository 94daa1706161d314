#include "server/front/grpc/session_call.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>

#include <utility>

namespace haptic::server {

SessionCall* SessionCall::begin(ServiceContext& context, Peer peer) {
  auto stream = std::make_shared<SessionCall>(context, std::move(peer), Carrier::kGrpc);
  stream->keep_alive();
  stream->SessionStream::begin();
  return stream.get();
}

void SessionCall::OnReadDone(bool ok) {
  const core::TimePoint arrival = context_.limits.clock({});
  // Half-closed, or cancelled: then the status goes nowhere.
  if (!ok) return lost();
  const std::size_t size = incoming_.Length();
  if (!may_parse(size)) return;
  if (!grpc::SerializationTraits<v1::SessionRequest>::Deserialize(&incoming_, &request_).ok()) {
    return unreadable("not a SessionRequest");
  }
  received(request_, size, arrival);
}

void SessionCall::OnDone() {
  done();
  GrpcStream::OnDone();
}

}  // namespace haptic::server
