#pragma once
/// HapticService on gRPC's callback API (private to server/front/grpc). Session and Watch speak
/// bytes, so that one serialised state serves every stream; EmergencyStop does, so that no mistake
/// in its message keeps it from stopping.

#include "haptic/v1/haptic_service.grpc.pb.h"
#include "server/front/service/calls.hpp"

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
  explicit HapticServiceImpl(ServiceContext& context) : context_(context), calls_(context) {}

  using Call = grpc::CallbackServerContext;
  using Unary = grpc::ServerUnaryReactor;
  using Bytes = grpc::ByteBuffer;

  Unary* GetServerInfo(Call* call, const v1::GetServerInfoRequest* request,
                       v1::GetServerInfoResponse* response) override;
  Unary* ListDevices(Call* call, const v1::ListDevicesRequest* request,
                     v1::ListDevicesResponse* response) override;
  grpc::ServerBidiReactor<Bytes, Bytes>* Session(Call* call) override;
  grpc::ServerWriteReactor<Bytes>* Watch(Call* call, const Bytes* request) override;
  Unary* Engage(Call* call, const v1::EngageRequest* request,
                v1::EngageResponse* response) override;
  Unary* Release(Call* call, const v1::ReleaseRequest* request,
                 v1::ReleaseResponse* response) override;
  Unary* UpdateSettings(Call* call, const v1::UpdateSettingsRequest* request,
                        v1::UpdateSettingsResponse* response) override;
  Unary* GetLinkStats(Call* call, const v1::GetLinkStatsRequest* request,
                      v1::GetLinkStatsResponse* response) override;
  /// A request that cannot be read stops every device.
  Unary* EmergencyStop(Call* call, const Bytes* request, Bytes* response) override;
  Unary* ClearFault(Call* call, const v1::ClearFaultRequest* request,
                    v1::ClearFaultResponse* response) override;

 private:
  template <typename Request, typename Response>
  Unary* run(Call* call, const Request& request, Response& response,
             void (Calls::*method)(const Request&, Response&, const ReplyPtr&));

  ServiceContext& context_;
  Calls calls_;
};

}  // namespace haptic::server
