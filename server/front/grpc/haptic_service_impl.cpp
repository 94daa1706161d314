#include "server/front/grpc/haptic_service_impl.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>

#include <memory>
#include <utility>

#include "server/front/grpc/peer_of.hpp"
#include "server/front/grpc/reply.hpp"
#include "server/front/grpc/session_call.hpp"
#include "server/front/grpc/watch_stream.hpp"
#include "server/front/session/refusals.hpp"

namespace haptic::server {
namespace {

using Unary = grpc::ServerUnaryReactor;

/// Lives until gRPC is done with the call, which is long after its end if the peer does not read.
class BookedUnary final : public Unary {
 public:
  explicit BookedUnary(std::shared_ptr<Account> account) : booked_(std::move(account)) {}
  void OnDone() override { delete this; }

 private:
  const BookedCall booked_;
};

Unary* booked(ServiceContext& context, const grpc::ServerContextBase& call) {
  return new BookedUnary(context.account_of(call.peer()));
}

Unary* finished(ServiceContext& context, const grpc::ServerContextBase& call,
                const grpc::Status& status) {
  Unary* reactor = booked(context, call);
  reactor->Finish(status);
  return reactor;
}

/// Its response is a message that gRPC gets as bytes.
class StopReply final : public GrpcReply {
 public:
  StopReply(Unary* reactor, grpc::ByteBuffer* bytes) : GrpcReply(reactor), bytes_(bytes) {}
  v1::EmergencyStopResponse response{};

 private:
  void send(const std::optional<Refusal>& why) override {
    if (!why) *bytes_ = to_buffer(to_outgoing(response));
    GrpcReply::send(why);
  }
  grpc::ByteBuffer* bytes_;
};

}  // namespace

template <typename Request, typename Response>
Unary* HapticServiceImpl::run(Call* call, const Request& request, Response& response,
                              void (Calls::*method)(const Request&, Response&, const ReplyPtr&)) {
  // gRPC has read the message already; it is booked to its connection.
  const std::size_t size = request.ByteSizeLong();
  context_.connections->account(call->peer())->call(size);
  if (const auto refusal = too_large(size)) return finished(context_, *call, to_status(*refusal));
  Unary* const reactor = booked(context_, *call);
  (calls_.*method)(request, response, std::make_shared<GrpcReply>(reactor));
  return reactor;
}

Unary* HapticServiceImpl::GetServerInfo(Call* call, const v1::GetServerInfoRequest* request,
                                        v1::GetServerInfoResponse* response) {
  return run(call, *request, *response, &Calls::get_server_info);
}

Unary* HapticServiceImpl::ListDevices(Call* call, const v1::ListDevicesRequest* request,
                                      v1::ListDevicesResponse* response) {
  return run(call, *request, *response, &Calls::list_devices);
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* HapticServiceImpl::Session(
    Call* call) {
  Peer peer = peer_of(*call);
  peer.account = context_.account_of(call->peer());
  return SessionCall::begin(context_, std::move(peer));
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* HapticServiceImpl::Watch(Call* call,
                                                                     const Bytes* request) {
  auto account = context_.account_of(call->peer());
  // Without a request the call was taken back: there is nothing to book.
  if (request->Valid()) account->call(request->Length());
  return WatchStream::begin(context_, *request, std::move(account));
}

Unary* HapticServiceImpl::Engage(Call* call, const v1::EngageRequest* request,
                                 v1::EngageResponse* response) {
  return run(call, *request, *response, &Calls::engage);
}

Unary* HapticServiceImpl::Release(Call* call, const v1::ReleaseRequest* request,
                                  v1::ReleaseResponse* response) {
  return run(call, *request, *response, &Calls::release);
}

Unary* HapticServiceImpl::UpdateSettings(Call* call, const v1::UpdateSettingsRequest* request,
                                         v1::UpdateSettingsResponse* response) {
  return run(call, *request, *response, &Calls::update_settings);
}

Unary* HapticServiceImpl::GetLinkStats(Call* call, const v1::GetLinkStatsRequest* request,
                                       v1::GetLinkStatsResponse* response) {
  return run(call, *request, *response, &Calls::get_link_stats);
}

Unary* HapticServiceImpl::EmergencyStop(Call* call, const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) {
  // Its caller took it back before it was whole: it names no device, and not all of them either.
  if (!request->Valid()) return finished(context_, *call, grpc::Status::CANCELLED);
  context_.connections->account(call->peer())->call(request->Length());
  v1::EmergencyStopRequest message;
  grpc::ByteBuffer bytes(*request);
  const bool parsed =
      grpc::SerializationTraits<v1::EmergencyStopRequest>::Deserialize(&bytes, &message).ok();
  Unary* const reactor = booked(context_, *call);
  const auto reply = std::make_shared<StopReply>(reactor, response);
  calls_.emergency_stop(parsed ? &message : nullptr, reply->response, reply);
  return reactor;
}

Unary* HapticServiceImpl::ClearFault(Call* call, const v1::ClearFaultRequest* request,
                                     v1::ClearFaultResponse* response) {
  return run(call, *request, *response, &Calls::clear_fault);
}

}  // namespace haptic::server
