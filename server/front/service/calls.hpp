#pragma once
/// The unary calls of HapticService, whatever carries them. Each calls its Reply once: at once, or
/// when the owner answers, or has given no answer in time.

#include <chrono>
#include <functional>
#include <optional>

#include "haptic/v1/haptic_service.pb.h"
#include "server/front/service/service_context.hpp"

namespace haptic::server {

/// Ends one call, once; absent: it succeeded. Any thread.
using Reply = std::function<void(const std::optional<Refusal>& why)>;

/// `response` lives until the reply has ended the call.
class Calls {
 public:
  /// For an answer of the owner, whose own bound (PendingRequests::kPatience) is the shorter one
  /// while the loop runs. With the time until Front::give_up() it is at most 500 ms.
  static constexpr std::chrono::milliseconds kPatience{400};

  explicit Calls(ServiceContext& context) : context_(context) {}

  void get_server_info(const v1::GetServerInfoRequest& request, v1::GetServerInfoResponse& response,
                       const Reply& reply);
  void list_devices(const v1::ListDevicesRequest& request, v1::ListDevicesResponse& response,
                    const Reply& reply);
  void engage(const v1::EngageRequest& request, v1::EngageResponse& response, const Reply& reply);
  void release(const v1::ReleaseRequest& request, v1::ReleaseResponse& response,
               const Reply& reply);
  void update_settings(const v1::UpdateSettingsRequest& request,
                       v1::UpdateSettingsResponse& response, const Reply& reply);
  void get_link_stats(const v1::GetLinkStatsRequest& request, v1::GetLinkStatsResponse& response,
                      const Reply& reply);
  /// Null: a request that could not be read, which stops every device. Every device gets its stop
  /// before any answers; the call ends when the last of them has latched.
  void emergency_stop(const v1::EmergencyStopRequest* request, v1::EmergencyStopResponse& response,
                      const Reply& reply);
  void clear_fault(const v1::ClearFaultRequest& request, v1::ClearFaultResponse& response,
                   const Reply& reply);

 private:
  /// Posts `request`; the owner's answer ends the call, and `fill` writes the response.
  void ask(const Request& request, const Reply& reply,
           std::function<void(const Answer&)> fill = {});

  ServiceContext& context_;
};

}  // namespace haptic::server
