#include "server/rpc/haptic_service_impl.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <mutex>
#include <numeric>
#include <utility>

#include "server/front/messages.hpp"
#include "server/front/refusals.hpp"
#include "server/rpc/peer.hpp"
#include "server/rpc/reply.hpp"
#include "server/rpc/session_stream.hpp"
#include "server/rpc/watch_stream.hpp"

namespace haptic::server {
namespace {

using Unary = grpc::ServerUnaryReactor;

constexpr std::size_t kLongestReason = 200;

/// Lives until gRPC is done with the call, which is long after its end if the peer does not read.
class BookedUnary final : public Unary {
 public:
  explicit BookedUnary(std::shared_ptr<Account> account) : booked_(std::move(account)) {}
  void OnDone() override { delete this; }

 private:
  const BookedCall booked_;
};

Unary* booked(ServiceContext& context, const grpc::ServerContextBase& call) {
  return new BookedUnary(context.account_of(call));
}

Unary* finished(ServiceContext& context, const grpc::ServerContextBase* call,
                const grpc::Status& status) {
  Unary* reactor = booked(context, *call);
  reactor->Finish(status);
  return reactor;
}

/// Of a call whose message gRPC has read already; books it to its connection.
template <typename Message>
std::optional<grpc::Status> oversized(ServiceContext& context, const grpc::ServerContextBase& call,
                                      const Message& request) {
  context.connections->account(call.peer())->call(request.ByteSizeLong());
  const auto refusal = too_large(request.ByteSizeLong());
  return refusal ? std::optional(to_status(*refusal)) : std::nullopt;
}

/// Asked by a session.
Request by_session(Request::Kind kind, const std::string& id) {
  Request request;
  request.kind = kind;
  request.session_id = session_id(id);
  return request;
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
  [[nodiscard]] grpc::Status status() const {
    if (failed.empty()) return grpc::Status::OK;
    return to_status({Refusal::Code::kUnavailable, "NO_ANSWER",
                      "the loop did not confirm the stop of " + failed});
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

Unary* HapticServiceImpl::GetServerInfo(Call* call, const v1::GetServerInfoRequest* request,
                                        v1::GetServerInfoResponse* response) {
  if (const auto status = oversized(context_, *call, *request))
    return finished(context_, call, *status);
  *response = to_proto(context_.server_facts());
  for (std::string& sentence : context_.weaknesses()) {
    response->add_insecure(std::move(sentence));
  }
  response->set_max_sessions(context_.config.max_sessions);
  response->set_sessions(context_.sessions());
  if (!context_.owner().devices().empty()) {
    set(*response->mutable_lease_timeout(), context_.facts(0).lease_timeout);
  }
  return finished(context_, call, grpc::Status::OK);
}

Unary* HapticServiceImpl::ListDevices(Call* call, const v1::ListDevicesRequest* request,
                                      v1::ListDevicesResponse* response) {
  if (const auto status = oversized(context_, *call, *request))
    return finished(context_, call, *status);
  for (std::size_t i = 0; i < context_.owner().devices().size(); ++i) {
    *response->add_devices() =
        describe(context_.facts(i), context_.owner().status(i), context_.config.period);
  }
  return finished(context_, call, grpc::Status::OK);
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* HapticServiceImpl::Session(
    Call* call) {
  Peer peer = peer_of(*call);
  peer.account = context_.account_of(*call);
  return SessionStream::begin(context_, std::move(peer));
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* HapticServiceImpl::Watch(Call* call,
                                                                     const Bytes* request) {
  auto account = context_.account_of(*call);
  // Without a request the call was taken back: there is nothing to book.
  if (request->Valid()) account->call(request->Length());
  return WatchStream::begin(context_, *request, std::move(account));
}

Unary* HapticServiceImpl::ask(Call* call, const Request& request,
                              std::function<void(const Answer&)> fill) {
  Unary* reactor = booked(context_, *call);
  const auto reply = std::make_shared<TickReply>(reactor);
  const std::uint64_t id =
      context_.ask(request, [reply, fill = std::move(fill)](const Answer& answer) {
        if (answer.refusal) return reply->finish(to_status(*answer.refusal));
        reply->finish(grpc::Status::OK, [&] {
          if (fill) fill(answer);
        });
      });
  reply->watch([this, id] { context_.cancel(id); });
  return reactor;
}

Unary* HapticServiceImpl::Engage(Call* call, const v1::EngageRequest* request,
                                 v1::EngageResponse* /*response*/) {
  if (const auto status = oversized(context_, *call, *request))
    return finished(context_, call, *status);
  return ask(call, by_session(Request::Kind::kEngage, request->session_id()));
}

Unary* HapticServiceImpl::Release(Call* call, const v1::ReleaseRequest* request,
                                  v1::ReleaseResponse* /*response*/) {
  if (const auto status = oversized(context_, *call, *request))
    return finished(context_, call, *status);
  return ask(call, by_session(Request::Kind::kRelease, request->session_id()));
}

Unary* HapticServiceImpl::UpdateSettings(Call* call, const v1::UpdateSettingsRequest* message,
                                         v1::UpdateSettingsResponse* response) {
  if (const auto status = oversized(context_, *call, *message))
    return finished(context_, call, *status);
  Request request = by_session(Request::Kind::kSettings, message->session_id());
  const auto settings = from_proto(*message);
  if (!settings) return finished(context_, call, to_status(settings.refusal));
  request.settings = *settings.value;
  return ask(call, request, [asked = request.settings, response](const Answer& answer) {
    *response = to_proto(asked, answer.settings);
  });
}

Unary* HapticServiceImpl::GetLinkStats(Call* call, const v1::GetLinkStatsRequest* request,
                                       v1::GetLinkStatsResponse* response) {
  if (const auto status = oversized(context_, *call, *request))
    return finished(context_, call, *status);
  if (!request->device().empty()) {
    const auto target = context_.device(request->device());
    if (!target) return finished(context_, call, to_status(target.refusal));
  }
  context_.streams.for_each(
      [&](OpenStream& stream) { stream.report(request->device(), *response); });
  if (context_.udp) report_unassigned(*context_.udp, *response);
  return finished(context_, call, grpc::Status::OK);
}

Unary* HapticServiceImpl::EmergencyStop(Call* call, const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) {
  // Its caller took it back before it was whole: it names no device, and not all of them either.
  if (!request->Valid()) return finished(context_, call, grpc::Status::CANCELLED);
  context_.connections->account(call->peer())->call(request->Length());
  std::vector<std::size_t> devices(context_.owner().devices().size());
  std::iota(devices.begin(), devices.end(), std::size_t{0});
  std::string reason = "by a request that could not be read";
  v1::EmergencyStopRequest message;
  grpc::ByteBuffer bytes(*request);
  if (grpc::SerializationTraits<v1::EmergencyStopRequest>::Deserialize(&bytes, &message).ok()) {
    reason = sanitised(message.reason(), kLongestReason);
    if (!message.device().empty()) {
      const auto target = context_.device(message.device());
      if (!target) return finished(context_, call, to_status(target.refusal));
      devices = {*target.value};
    }
  }
  Unary* reactor = booked(context_, *call);
  const auto reply = std::make_shared<TickReply>(reactor);
  const auto round = std::make_shared<StopRound>();
  round->open = devices.size();
  std::vector<std::uint64_t> asked;
  for (const std::size_t device : devices) {
    Request stop;
    stop.kind = Request::Kind::kStop;
    stop.device = static_cast<std::uint32_t>(device);
    stop.text = reason;
    const std::string& name = context_.facts(device).name;
    asked.push_back(context_.ask(stop, [round, reply, response, &name](const Answer& answer) {
      if (!round->take(name, answer)) return;
      reply->finish(round->status(), [&] { *response = to_buffer(round->stopped); });
    }));
  }
  reply->watch([this, asked = std::move(asked)] {
    for (const std::uint64_t id : asked) context_.cancel(id);
  });
  spdlog::warn("emergency stop of {}: {}",
               devices.size() == 1 ? context_.facts(devices[0]).name : "all",
               reason.empty() ? "no reason given" : "'" + reason + "'");
  return reactor;
}

Unary* HapticServiceImpl::ClearFault(Call* call, const v1::ClearFaultRequest* request,
                                     v1::ClearFaultResponse* response) {
  if (const auto status = oversized(context_, *call, *request))
    return finished(context_, call, *status);
  const auto target = context_.device(request->device());
  if (!target) return finished(context_, call, to_status(target.refusal));
  const auto faults = fault_set(*request);
  if (!faults) return finished(context_, call, to_status(faults.refusal));
  Request clear;
  clear.kind = Request::Kind::kClear;
  clear.device = static_cast<std::uint32_t>(*target.value);
  clear.faults = *faults.value;
  return ask(call, clear, [response](const Answer& answer) {
    for (std::uint32_t id = 1; id < 32; ++id) {
      if (answer.faults.has(static_cast<core::Fault>(id))) response->add_cleared(id);
    }
  });
}

}  // namespace haptic::server
