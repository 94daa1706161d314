#pragma once
/// The unary calls of HapticService, whatever carries them. Each ends its Reply once: at once, or
/// when the owner answers.

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include "haptic/v1/haptic_service.pb.h"
#include "server/front/service/service_context.hpp"

namespace haptic::server {

/// How a carrier ends one call. Any thread.
class Reply : public std::enable_shared_from_this<Reply> {
 public:
  /// For an answer of the owner, whose own bound (PendingRequests::kPatience) is the shorter one
  /// while the loop runs.
  static constexpr std::chrono::milliseconds kPatience{500};

  Reply() = default;
  virtual ~Reply() = default;
  Reply(const Reply&) = delete;
  Reply& operator=(const Reply&) = delete;

  /// The first call ends it; `fill` writes the response just before, and only then.
  void finish(const std::optional<Refusal>& why = {}, const std::function<void()>& fill = {});
  /// If no answer came within kPatience `give_up` is called, and the call ends: UNAVAILABLE.
  virtual void watch(std::function<void()> give_up) = 0;

 protected:
  /// Once.
  virtual void send(const std::optional<Refusal>& why) = 0;
  [[nodiscard]] bool finished() const noexcept { return finished_.load(); }
  /// Called by watch() when the time is up.
  void time_is_up(const std::function<void()>& give_up);

 private:
  std::atomic<bool> finished_{false};
};
using ReplyPtr = std::shared_ptr<Reply>;

/// `response` lives until the reply has ended the call.
class Calls {
 public:
  explicit Calls(ServiceContext& context) : context_(context) {}

  void get_server_info(const v1::GetServerInfoRequest& request, v1::GetServerInfoResponse& response,
                       const ReplyPtr& reply);
  void list_devices(const v1::ListDevicesRequest& request, v1::ListDevicesResponse& response,
                    const ReplyPtr& reply);
  void engage(const v1::EngageRequest& request, v1::EngageResponse& response,
              const ReplyPtr& reply);
  void release(const v1::ReleaseRequest& request, v1::ReleaseResponse& response,
               const ReplyPtr& reply);
  void update_settings(const v1::UpdateSettingsRequest& request,
                       v1::UpdateSettingsResponse& response, const ReplyPtr& reply);
  void get_link_stats(const v1::GetLinkStatsRequest& request, v1::GetLinkStatsResponse& response,
                      const ReplyPtr& reply);
  /// Null: a request that could not be read, which stops every device. Every device gets its stop
  /// before any answers; the call ends when the last of them has latched.
  void emergency_stop(const v1::EmergencyStopRequest* request, v1::EmergencyStopResponse& response,
                      const ReplyPtr& reply);
  void clear_fault(const v1::ClearFaultRequest& request, v1::ClearFaultResponse& response,
                   const ReplyPtr& reply);

 private:
  /// Posts `request`; the owner's answer ends the call, and `fill` writes the response.
  void ask(const Request& request, const ReplyPtr& reply,
           std::function<void(const Answer&)> fill = {});

  ServiceContext& context_;
};

}  // namespace haptic::server
