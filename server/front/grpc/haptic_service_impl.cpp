#include "server/front/grpc/haptic_service_impl.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>

#include <optional>
#include <string_view>
#include <utility>

#include "haptic/v1/haptic_service.grpc.pb.h"
#include "server/front/grpc/peer_of.hpp"
#include "server/front/grpc/reply.hpp"
#include "server/front/grpc/session_call.hpp"
#include "server/front/grpc/watch_stream.hpp"
#include "server/front/service/unary_methods.hpp"
#include "server/front/session/refusals.hpp"

namespace haptic::server {
namespace {

using Unary = grpc::ServerUnaryReactor;
using Bytes = grpc::ByteBuffer;

/// Lives until gRPC is done with the call, which is long after its end if the peer does not read.
class BookedUnary final : public Unary {
 public:
  explicit BookedUnary(std::shared_ptr<Account> account) : booked_(std::move(account)) {}
  void OnDone() override { delete this; }

 private:
  const BookedCall booked_;
};

using RawCalls = v1::HapticService::WithRawCallbackMethod_GetServerInfo<
    v1::HapticService::WithRawCallbackMethod_ListDevices<
        v1::HapticService::WithRawCallbackMethod_Session<
            v1::HapticService::WithRawCallbackMethod_Watch<
                v1::HapticService::WithRawCallbackMethod_Engage<
                    v1::HapticService::WithRawCallbackMethod_Release<
                        v1::HapticService::WithRawCallbackMethod_UpdateSettings<
                            v1::HapticService::WithRawCallbackMethod_GetLinkStats<
                                v1::HapticService::WithRawCallbackMethod_EmergencyStop<
                                    v1::HapticService::WithRawCallbackMethod_ClearFault<
                                        v1::HapticService::Service>>>>>>>>>>;

class HapticServiceImpl final : public RawCalls {
 public:
  explicit HapticServiceImpl(ServiceContext& context) : context_(context), calls_(context) {}

  using Call = grpc::CallbackServerContext;

  Unary* GetServerInfo(Call* call, const Bytes* request, Bytes* response) override {
    return run(*call, *request, *response, "GetServerInfo");
  }
  Unary* ListDevices(Call* call, const Bytes* request, Bytes* response) override {
    return run(*call, *request, *response, "ListDevices");
  }
  Unary* Engage(Call* call, const Bytes* request, Bytes* response) override {
    return run(*call, *request, *response, "Engage");
  }
  Unary* Release(Call* call, const Bytes* request, Bytes* response) override {
    return run(*call, *request, *response, "Release");
  }
  Unary* UpdateSettings(Call* call, const Bytes* request, Bytes* response) override {
    return run(*call, *request, *response, "UpdateSettings");
  }
  Unary* GetLinkStats(Call* call, const Bytes* request, Bytes* response) override {
    return run(*call, *request, *response, "GetLinkStats");
  }
  Unary* EmergencyStop(Call* call, const Bytes* request, Bytes* response) override {
    return run(*call, *request, *response, kStop);
  }
  Unary* ClearFault(Call* call, const Bytes* request, Bytes* response) override {
    return run(*call, *request, *response, "ClearFault");
  }

  grpc::ServerBidiReactor<Bytes, Bytes>* Session(Call* call) override {
    Peer peer = peer_of(*call);
    peer.account = context_.account_of(call->peer());
    return SessionCall::begin(context_, std::move(peer));
  }
  grpc::ServerWriteReactor<Bytes>* Watch(Call* call, const Bytes* request) override {
    auto account = context_.account_of(call->peer());
    // Without a request the call was taken back: there is nothing to book.
    if (request->Valid()) account->call(request->Length());
    return WatchStream::begin(context_, *request, std::move(account));
  }

 private:
  [[nodiscard]] Unary* booked(const Call& call) {
    return new BookedUnary(context_.account_of(call.peer()));
  }
  [[nodiscard]] Unary* finished(const Call& call, const grpc::Status& status) {
    Unary* const reactor = booked(call);
    reactor->Finish(status);
    return reactor;
  }
  [[nodiscard]] Unary* run(const Call& call, const Bytes& request, Bytes& response,
                           std::string_view name) {
    // Its caller took it back before it was whole: it asks for nothing, and stops nothing.
    if (!request.Valid()) return finished(call, grpc::Status::CANCELLED);
    // gRPC has read the message already; it is booked to its connection.
    const std::size_t size = request.Length();
    context_.connections->account(call.peer())->call(size);
    const auto refusal = name == kStop ? std::nullopt : too_large(size);
    if (refusal) return finished(call, to_status(*refusal));
    const UnaryMethod& method = *find_method(name);
    const auto open = std::make_shared<UnaryCall>();
    method.make(*open);
    Bytes bytes(request);
    open->readable = grpc::SerializationTraits<google::protobuf::Message>::Deserialize(
                         &bytes, open->request.get())
                         .ok();
    if (!open->readable && name != kStop) {
      return finished(
          call, to_status(invalid_field("message", "is not a " + open->request->GetTypeName())));
    }
    Unary* const reactor = booked(call);
    method.run(calls_, *open, [reactor, &response, open](const std::optional<Refusal>& why) {
      if (!why) response = to_buffer(to_outgoing(*open->response));
      reactor->Finish(to_status(why));
    });
    return reactor;
  }

  ServiceContext& context_;
  Calls calls_;
};

}  // namespace

std::unique_ptr<grpc::Service> haptic_service(ServiceContext& context) {
  return std::make_unique<HapticServiceImpl>(context);
}

}  // namespace haptic::server
