#pragma once
/// HapticService on gRPC's callback API (private to server/rpc). Session and Watch speak bytes, so
/// that one serialised state serves every stream; EmergencyStop does, so that no mistake in its
/// message keeps it from stopping.

#include <functional>

#include "haptic/v1/haptic_service.grpc.pb.h"
#include "server/rpc/service_context.hpp"

namespace haptic::server {

template <typename Base>
using TypedCalls = v1::HapticService::WithCallbackMethod_GetServerInfo<
    v1::HapticService::WithCallbackMethod_ListDevices<
        v1::HapticService::WithCallbackMethod_Engage<v1::HapticService::WithCallbackMethod_Release<
            v1::HapticService::WithCallbackMethod_UpdateSettings<
                v1::HapticService::WithCallbackMethod_GetLinkStats<
                    v1::HapticService::WithCallbackMethod_ClearFault<Base>>>>>>>;
using RawCalls =
    v1::HapticService::WithRawCallbackMethod_Session<v1::HapticService::WithRawCallbackMethod_Watch<
        v1::HapticService::WithRawCallbackMethod_EmergencyStop<v1::HapticService::Service>>>;

class HapticServiceImpl final : public TypedCalls<RawCalls> {
 public:
  explicit HapticServiceImpl(ServiceContext& context) : context_(context) {}

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* call,
                                          const v1::GetServerInfoRequest* request,
                                          v1::GetServerInfoResponse* response) override;
  grpc::ServerUnaryReactor* ListDevices(grpc::CallbackServerContext* call,
                                        const v1::ListDevicesRequest* request,
                                        v1::ListDevicesResponse* response) override;
  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Session(
      grpc::CallbackServerContext* call) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* Watch(grpc::CallbackServerContext* call,
                                                    const grpc::ByteBuffer* request) override;
  grpc::ServerUnaryReactor* Engage(grpc::CallbackServerContext* call,
                                   const v1::EngageRequest* request,
                                   v1::EngageResponse* response) override;
  grpc::ServerUnaryReactor* Release(grpc::CallbackServerContext* call,
                                    const v1::ReleaseRequest* request,
                                    v1::ReleaseResponse* response) override;
  grpc::ServerUnaryReactor* UpdateSettings(grpc::CallbackServerContext* call,
                                           const v1::UpdateSettingsRequest* request,
                                           v1::UpdateSettingsResponse* response) override;
  grpc::ServerUnaryReactor* GetLinkStats(grpc::CallbackServerContext* call,
                                         const v1::GetLinkStatsRequest* request,
                                         v1::GetLinkStatsResponse* response) override;
  /// A request that cannot be read stops every device.
  grpc::ServerUnaryReactor* EmergencyStop(grpc::CallbackServerContext* call,
                                          const grpc::ByteBuffer* request,
                                          grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ClearFault(grpc::CallbackServerContext* call,
                                       const v1::ClearFaultRequest* request,
                                       v1::ClearFaultResponse* response) override;

 private:
  /// Posts `request`; the owner's answer finishes the call, and `fill` writes the response.
  grpc::ServerUnaryReactor* ask(grpc::CallbackServerContext* call, const Request& request,
                                std::function<void(const Answer&)> fill = {});

  ServiceContext& context_;
};

}  // namespace haptic::server
