#pragma once
/// The unary calls by name (private to web_server.cpp).

#include <memory>
#include <string>
#include <string_view>

#include "grpc/health/v1/health.pb.h"
#include "server/front/web/web_shared.hpp"

namespace haptic::server {

/// The messages of a call by HTTP.
struct UnaryCall {
  std::unique_ptr<google::protobuf::Message> request{};
  std::unique_ptr<google::protobuf::Message> response{};
  bool json{false};
  bool readable{true};  ///< its request was
};

/// Empty: `message` is what the body says. Else why not, fit for logs.
inline std::string parse(const std::string& body, bool json, google::protobuf::Message& message) {
  if (json) return Json::read(body, message);
  return message.ParseFromString(body) ? "" : "not a " + message.GetDescriptor()->name();
}

struct UnaryMethod {
  const char* path;
  bool observer;  ///< whether an observer may
  void (*make)(UnaryCall& call);
  void (*run)(Calls& calls, const UnaryCall& call, const ReplyPtr& reply);
};

template <typename Request, typename Response>
void make_messages(UnaryCall& call) {
  call.request = std::make_unique<Request>();
  call.response = std::make_unique<Response>();
}

template <auto kMethod>
struct CallOf;
template <typename Request, typename Response,
          void (Calls::*kMethod)(const Request&, Response&, const ReplyPtr&)>
struct CallOf<kMethod> {
  static constexpr auto make = make_messages<Request, Response>;
  static void run(Calls& calls, const UnaryCall& call, const ReplyPtr& reply) {
    (calls.*kMethod)(static_cast<const Request&>(*call.request),
                     static_cast<Response&>(*call.response), reply);
  }
};

/// A request that cannot be read stops all devices, as by gRPC.
inline void run_stop(Calls& calls, const UnaryCall& call, const ReplyPtr& reply) {
  const auto* request = static_cast<const v1::EmergencyStopRequest*>(call.request.get());
  calls.emergency_stop(call.readable ? request : nullptr,
                       static_cast<v1::EmergencyStopResponse&>(*call.response), reply);
}

template <auto kMethod>
constexpr UnaryMethod method(const char* path, bool observer) {
  return {path, observer, CallOf<kMethod>::make, CallOf<kMethod>::run};
}

inline constexpr std::string_view kStopPath = "/haptic.v1.HapticService/EmergencyStop";
inline constexpr std::string_view kSessionPath = "/haptic.v1.HapticService/Session";
inline constexpr std::string_view kHealthPath = "/grpc.health.v1.Health/Check";

inline const UnaryMethod* find_method(std::string_view path) {
  static constexpr UnaryMethod kMethods[] = {
      method<&Calls::get_server_info>("/haptic.v1.HapticService/GetServerInfo", true),
      method<&Calls::list_devices>("/haptic.v1.HapticService/ListDevices", true),
      method<&Calls::engage>("/haptic.v1.HapticService/Engage", false),
      method<&Calls::release>("/haptic.v1.HapticService/Release", false),
      method<&Calls::update_settings>("/haptic.v1.HapticService/UpdateSettings", false),
      method<&Calls::get_link_stats>("/haptic.v1.HapticService/GetLinkStats", true),
      {kStopPath.data(), true, make_messages<v1::EmergencyStopRequest, v1::EmergencyStopResponse>,
       run_stop},
      method<&Calls::clear_fault>("/haptic.v1.HapticService/ClearFault", false)};
  for (const UnaryMethod& each : kMethods) {
    if (path == each.path) return &each;
  }
  return nullptr;
}

/// Ends a call by HTTP. Any thread; the rest happens on the server's.
template <typename Connection>
class WebReply final : public Reply {
 public:
  WebReply(std::shared_ptr<Connection> connection, std::shared_ptr<Account> account)
      : loop_runs_(connection->shared().loop.get_executor()),
        connection_(std::move(connection)),
        booked_(std::move(account)),
        timer_(connection_->shared().loop) {}

  UnaryCall call{};

  /// On the server's thread.
  void watch(std::function<void()> give_up) override {
    if (finished()) return;
    timer_.expires_after(kPatience);
    timer_.async_wait([self = shared_from_this(), this,
                       give_up = std::move(give_up)](beast::error_code cancelled) {
      if (!cancelled) time_is_up(give_up);
    });
  }

 private:
  void send(const std::optional<Refusal>& why) override {
    asio::post(connection_->shared().loop, [self = shared_from_this(), this, why] {
      timer_.cancel();
      connection_->answer_call(call, why);
    });
  }

  /// The loop goes on until the answer, from whichever thread, has come.
  const asio::executor_work_guard<asio::io_context::executor_type> loop_runs_;
  const std::shared_ptr<Connection> connection_;
  const BookedCall booked_;
  asio::steady_timer timer_;
};

}  // namespace haptic::server
