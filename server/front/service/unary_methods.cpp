#include "server/front/service/unary_methods.hpp"

namespace haptic::server {
namespace {

template <typename Request, typename Response>
void make_messages(UnaryCall& call) {
  call.request = std::make_unique<Request>();
  call.response = std::make_unique<Response>();
}

template <auto kMethod>
struct CallOf;
template <typename Request, typename Response,
          void (Calls::*kMethod)(const Request&, Response&, const Reply&)>
struct CallOf<kMethod> {
  static constexpr auto make = make_messages<Request, Response>;
  static void run(Calls& calls, const UnaryCall& call, const Reply& reply) {
    (calls.*kMethod)(static_cast<const Request&>(*call.request),
                     static_cast<Response&>(*call.response), reply);
  }
};

/// A request that cannot be read stops all devices.
void run_stop(Calls& calls, const UnaryCall& call, const Reply& reply) {
  const auto* request = static_cast<const v1::EmergencyStopRequest*>(call.request.get());
  calls.emergency_stop(call.readable ? request : nullptr,
                       static_cast<v1::EmergencyStopResponse&>(*call.response), reply);
}

template <auto kMethod>
constexpr UnaryMethod method(std::string_view name, bool observer) {
  return {name, observer, CallOf<kMethod>::make, CallOf<kMethod>::run};
}

constexpr UnaryMethod kMethods[] = {
    method<&Calls::get_server_info>("GetServerInfo", true),
    method<&Calls::list_devices>("ListDevices", true),
    method<&Calls::engage>("Engage", false),
    method<&Calls::release>("Release", false),
    method<&Calls::update_settings>("UpdateSettings", false),
    method<&Calls::get_link_stats>("GetLinkStats", true),
    {kStop, true, make_messages<v1::EmergencyStopRequest, v1::EmergencyStopResponse>, run_stop},
    method<&Calls::clear_fault>("ClearFault", false)};

}  // namespace

const UnaryMethod* find_method(std::string_view name) {
  for (const UnaryMethod& each : kMethods) {
    if (name == each.name) return &each;
  }
  return nullptr;
}

}  // namespace haptic::server
