#include "server/front/service/calls.hpp"

#include <spdlog/spdlog.h>

#include <mutex>
#include <numeric>
#include <utility>
#include <vector>

#include "server/front/net/protection.hpp"
#include "server/front/session/messages.hpp"
#include "server/front/session/refusals.hpp"
#include "server/front/udp/session_path.hpp"

namespace haptic::server {
namespace {

constexpr std::size_t kLongestReason = 200;

/// Asked by a session.
Request by_session(Request::Kind kind, const std::string& id) {
  return {.kind = kind, .session_id = session_id(id)};
}

/// An emergency stop of several devices.
struct StopRound {
  std::mutex mutex{};
  std::size_t open{0};
  v1::EmergencyStopResponse stopped{};
  std::string failed{};  ///< devices whose loop did not answer

  /// True if this is the last answer.
  bool take(const std::string& device, const Answer& answer) {
    const std::lock_guard lock(mutex);
    if (answer.refusal) {
      failed += (failed.empty() ? "'" : ", '") + device + "'";
    } else {
      stopped.add_stopped(device);
    }
    return --open == 0;
  }
  [[nodiscard]] std::optional<Refusal> refusal() const {
    if (failed.empty()) return std::nullopt;
    return Refusal{Refusal::Code::kUnavailable, "NO_ANSWER",
                   "the loop did not confirm the stop of " + failed};
  }
};

Outcome<core::FaultSet> fault_set(const v1::ClearFaultRequest& request) {
  core::FaultSet faults;
  for (const std::uint32_t id : request.fault_ids()) {
    if (id < 1 || id > 31) {
      return invalid_field("fault_ids", "= " + std::to_string(id) + ": must be 1..31");
    }
    faults.set(static_cast<core::Fault>(id));
  }
  return faults;
}

}  // namespace

void Calls::ask(const Request& request, const Reply& reply,
                std::function<void(const Answer&)> fill) {
  context_.ask(
      request,
      [reply, fill = std::move(fill)](const Answer& answer) {
        if (!answer.refusal && fill) fill(answer);
        reply(answer.refusal);
      },
      steady_now() + kPatience);
}

void Calls::get_server_info(const v1::GetServerInfoRequest& /*request*/,
                            v1::GetServerInfoResponse& response, const Reply& reply) {
  response = to_proto(context_.server_facts());
  for (std::string& sentence : weaknesses(context_.config)) {
    response.add_insecure(std::move(sentence));
  }
  response.set_max_sessions(context_.config.max_sessions);
  response.set_sessions(context_.sessions());
  if (!context_.owner().devices().empty()) {
    set(*response.mutable_lease_timeout(), context_.facts(0).lease_timeout);
  }
  reply({});
}

void Calls::list_devices(const v1::ListDevicesRequest& /*request*/,
                         v1::ListDevicesResponse& response, const Reply& reply) {
  for (std::size_t i = 0; i < context_.owner().devices().size(); ++i) {
    *response.add_devices() =
        describe(context_.facts(i), context_.owner().status(i), context_.config.period);
  }
  reply({});
}

void Calls::engage(const v1::EngageRequest& request, v1::EngageResponse& /*response*/,
                   const Reply& reply) {
  ask(by_session(Request::Kind::kEngage, request.session_id()), reply);
}

void Calls::release(const v1::ReleaseRequest& request, v1::ReleaseResponse& /*response*/,
                    const Reply& reply) {
  ask(by_session(Request::Kind::kRelease, request.session_id()), reply);
}

void Calls::update_settings(const v1::UpdateSettingsRequest& message,
                            v1::UpdateSettingsResponse& response, const Reply& reply) {
  Request request = by_session(Request::Kind::kSettings, message.session_id());
  const auto settings = from_proto(message);
  if (!settings) return reply(settings.refusal);
  request.settings = *settings.value;
  ask(request, reply, [asked = request.settings, &response](const Answer& answer) {
    response = to_proto(asked, answer.settings);
  });
}

void Calls::get_link_stats(const v1::GetLinkStatsRequest& request,
                           v1::GetLinkStatsResponse& response, const Reply& reply) {
  if (!request.device().empty()) {
    const auto target = context_.device(request.device());
    if (!target) return reply(target.refusal);
  }
  context_.streams.for_each([&](OpenStream& stream) { stream.report(request.device(), response); });
  if (context_.udp) report_unassigned(*context_.udp, response);
  reply({});
}

void Calls::emergency_stop(const v1::EmergencyStopRequest* request,
                           v1::EmergencyStopResponse& response, const Reply& reply) {
  std::vector<std::size_t> devices(context_.owner().devices().size());
  std::iota(devices.begin(), devices.end(), std::size_t{0});
  std::string reason = "by a request that could not be read";
  if (request != nullptr) {
    reason = sanitised(request->reason(), kLongestReason);
    if (!request->device().empty()) {
      const auto target = context_.device(request->device());
      if (!target) return reply(target.refusal);
      devices = {*target.value};
    }
  }
  const auto round = std::make_shared<StopRound>();
  round->open = devices.size();
  const core::TimePoint until = steady_now() + kPatience;
  for (const std::size_t device : devices) {
    const std::string& name = context_.facts(device).name;
    context_.ask(
        {.kind = Request::Kind::kStop,
         .device = static_cast<std::uint32_t>(device),
         .text = reason},
        [round, reply, &response, &name](const Answer& answer) {
          if (!round->take(name, answer)) return;
          response = round->stopped;
          reply(round->refusal());
        },
        until);
  }
  spdlog::warn("emergency stop of {}: {}",
               devices.size() == 1 ? context_.facts(devices[0]).name : "all",
               reason.empty() ? "no reason given" : "'" + reason + "'");
}

void Calls::clear_fault(const v1::ClearFaultRequest& request, v1::ClearFaultResponse& response,
                        const Reply& reply) {
  const auto target = context_.device(request.device());
  if (!target) return reply(target.refusal);
  const auto faults = fault_set(request);
  if (!faults) return reply(faults.refusal);
  ask({.kind = Request::Kind::kClear,
       .device = static_cast<std::uint32_t>(*target.value),
       .faults = *faults.value},
      reply, [&response](const Answer& answer) {
        for (std::uint32_t id = 1; id < 32; ++id) {
          if (answer.faults.has(static_cast<core::Fault>(id))) response.add_cleared(id);
        }
      });
}

}  // namespace haptic::server
