#include "server/rpc/haptic_service_impl.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>
#include <spdlog/spdlog.h>

#include <memory>

#include "server/rpc/convert.hpp"
#include "server/rpc/link_report.hpp"
#include "server/rpc/peer.hpp"
#include "server/rpc/session_stream.hpp"
#include "server/rpc/status.hpp"
#include "server/rpc/stop_round.hpp"
#include "server/rpc/tick_reply.hpp"
#include "server/rpc/watch_stream.hpp"

namespace haptic::server {
namespace {

constexpr std::size_t kLongestReason = 200;

grpc::ServerUnaryReactor* finished(grpc::CallbackServerContext* call, const grpc::Status& status) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  reactor->Finish(status);
  return reactor;
}

/// Of a call whose message gRPC has read already.
template <typename Message>
std::optional<grpc::Status> oversized(const Message& request) {
  const auto refusal = too_large(request.ByteSizeLong());
  return refusal ? std::optional(to_status(*refusal)) : std::nullopt;
}

Refusal no_such_session() {
  return {Refusal::Code::kPermission, "NOT_CONTROLLER", "session_id: no such session is open", {}};
}

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

grpc::ServerUnaryReactor* HapticServiceImpl::GetServerInfo(grpc::CallbackServerContext* call,
                                                           const v1::GetServerInfoRequest* request,
                                                           v1::GetServerInfoResponse* response) {
  if (const auto status = oversized(*request)) return finished(call, *status);
  *response = to_proto(context_.facts());
  for (std::string& sentence : context_.weaknesses()) {
    response->add_insecure(std::move(sentence));
  }
  response->set_max_sessions(context_.config.max_sessions);
  response->set_sessions(context_.registry.sessions());
  if (!context_.devices.empty()) {
    set(*response->mutable_lease_timeout(), context_.devices.front()->lease_timeout());
  }
  return finished(call, grpc::Status::OK);
}

grpc::ServerUnaryReactor* HapticServiceImpl::ListDevices(grpc::CallbackServerContext* call,
                                                         const v1::ListDevicesRequest* request,
                                                         v1::ListDevicesResponse* response) {
  if (const auto status = oversized(*request)) return finished(call, *status);
  for (const DeviceSessions* device : context_.devices) {
    *response->add_devices() = describe(*device, context_.config.period);
  }
  return finished(call, grpc::Status::OK);
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* HapticServiceImpl::Session(
    grpc::CallbackServerContext* call) {
  return SessionStream::begin(context_, peer_of(*call));
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* HapticServiceImpl::Watch(
    grpc::CallbackServerContext* /*call*/, const grpc::ByteBuffer* request) {
  return WatchStream::begin(context_, *request);
}

grpc::ServerUnaryReactor* HapticServiceImpl::ask(grpc::CallbackServerContext* call,
                                                 const std::string& session_id, Ask question) {
  DeviceSessions* device = context_.registry.find(session_id);
  if (device == nullptr) return finished(call, to_status(no_such_session()));
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  const auto reply = std::make_shared<TickReply>(reactor);
  const Ticket ticket = (device->*question)(session_id, [reply](const Outcome<Done>& outcome) {
    reply->finish(outcome ? grpc::Status::OK : to_status(outcome.refusal));
  });
  reply->watch([device, ticket] { device->cancel(ticket); });
  return reactor;
}

grpc::ServerUnaryReactor* HapticServiceImpl::Engage(grpc::CallbackServerContext* call,
                                                    const v1::EngageRequest* request,
                                                    v1::EngageResponse* /*response*/) {
  if (const auto status = oversized(*request)) return finished(call, *status);
  return ask(call, request->session_id(), &DeviceSessions::engage);
}

grpc::ServerUnaryReactor* HapticServiceImpl::Release(grpc::CallbackServerContext* call,
                                                     const v1::ReleaseRequest* request,
                                                     v1::ReleaseResponse* /*response*/) {
  if (const auto status = oversized(*request)) return finished(call, *status);
  return ask(call, request->session_id(), &DeviceSessions::release);
}

grpc::ServerUnaryReactor* HapticServiceImpl::UpdateSettings(
    grpc::CallbackServerContext* call, const v1::UpdateSettingsRequest* request,
    v1::UpdateSettingsResponse* response) {
  if (const auto status = oversized(*request)) return finished(call, *status);
  DeviceSessions* device = context_.registry.find(request->session_id());
  if (device == nullptr) return finished(call, to_status(no_such_session()));
  const auto settings = from_proto(*request);
  if (!settings) return finished(call, to_status(settings.refusal));
  const auto answer = device->update_settings(request->session_id(), *settings.value);
  if (!answer) return finished(call, to_status(answer.refusal));
  *response = to_proto(*answer.value);
  return finished(call, grpc::Status::OK);
}

grpc::ServerUnaryReactor* HapticServiceImpl::GetLinkStats(grpc::CallbackServerContext* call,
                                                          const v1::GetLinkStatsRequest* request,
                                                          v1::GetLinkStatsResponse* response) {
  if (const auto status = oversized(*request)) return finished(call, *status);
  if (!request->device().empty()) {
    const auto target = context_.device(request->device());
    if (!target) return finished(call, to_status(target.refusal));
  }
  context_.streams.for_each(
      [&](OpenStream& stream) { stream.report(request->device(), *response); });
  if (context_.udp) report_unassigned(*context_.udp, *response);
  return finished(call, grpc::Status::OK);
}

grpc::ServerUnaryReactor* HapticServiceImpl::EmergencyStop(grpc::CallbackServerContext* call,
                                                           const grpc::ByteBuffer* request,
                                                           grpc::ByteBuffer* response) {
  std::vector<DeviceSessions*> devices = context_.devices;
  std::string reason = "by a request that could not be read";
  v1::EmergencyStopRequest message;
  grpc::ByteBuffer bytes(*request);
  if (grpc::SerializationTraits<v1::EmergencyStopRequest>::Deserialize(&bytes, &message).ok()) {
    reason = sanitised(message.reason(), kLongestReason);
    if (!message.device().empty()) {
      const auto target = context_.device(message.device());
      if (!target) return finished(call, to_status(target.refusal));
      devices = {target.value->device};
    }
  }
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  stop_all(devices, reason, reactor, response);
  spdlog::warn("emergency stop of {}: {}", devices.size() == 1 ? devices[0]->name() : "all",
               reason.empty() ? "no reason given" : "'" + reason + "'");
  return reactor;
}

grpc::ServerUnaryReactor* HapticServiceImpl::ClearFault(grpc::CallbackServerContext* call,
                                                        const v1::ClearFaultRequest* request,
                                                        v1::ClearFaultResponse* response) {
  if (const auto status = oversized(*request)) return finished(call, *status);
  const auto target = context_.device(request->device());
  if (!target) return finished(call, to_status(target.refusal));
  const auto faults = fault_set(*request);
  if (!faults) return finished(call, to_status(faults.refusal));
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  const auto reply = std::make_shared<TickReply>(reactor);
  DeviceSessions* device = target.value->device;
  const Ticket ticket = device->clear_faults(
      *faults.value, [reply, response](const Outcome<core::FaultSet>& outcome) {
        if (!outcome) return reply->finish(to_status(outcome.refusal));
        reply->finish(grpc::Status::OK, [&] {
          for (std::uint32_t id = 1; id < 32; ++id) {
            if (outcome.value->has(static_cast<core::Fault>(id))) response->add_cleared(id);
          }
        });
      });
  reply->watch([device, ticket] { device->cancel(ticket); });
  return reactor;
}

}  // namespace haptic::server
