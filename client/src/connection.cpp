#include "haptic/client/connection.hpp"

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/impl/codegen/proto_utils.h>

#include <fstream>
#include <future>

#include "call.hpp"
#include "convert.hpp"
#include "grpc/health/v1/health.pb.h"
#include "haptic/wire/ports.hpp"
#include "haptic/wire/utf8.hpp"
#include "remote_session.hpp"
#include "remote_watch.hpp"

namespace haptic::client {

const char* const kDefaultServer = wire::kDefaultServer;

class Connection::Impl {
 public:
  Impl(const std::string& server, const std::shared_ptr<grpc::ChannelCredentials>& credentials,
       const std::string& server_name)
      : address(server) {
    check_form(address);
    grpc::ChannelArguments arguments;
    if (!server_name.empty()) arguments.SetSslTargetNameOverride(server_name);
    // A network that was unplugged leaves a connection that looks alive: TCP would try for minutes.
    // It is given up if nothing that was sent is acknowledged, or a ping after 1 s of silence not
    // answered, for 2 s, which is how long a silent lease lasts by default.
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 1000);
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 2000);       // and TCP_USER_TIMEOUT
    arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);  // as many as there are silences
    arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
    // In spite of its name: how long one attempt may take. On a link of 100 ms each way TCP and
    // HTTP/2 need 400 ms, and more if packets are lost. A longer attempt would wait for TCP's own
    // repetitions, 1, 2, 4 s apart, after the network is back.
    arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 1500);
    arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 500);
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);  // $http_proxy would see samples and stops
    // Every connection of this library is its own: one that is stuck must not hold up another.
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    channel = grpc::CreateCustomChannel(address, credentials, arguments);
    stub = v1::HapticService::NewStub(channel);
  }

  /// The form only, so that gRPC need not guess. Throws.
  static void check_form(const std::string& address) {
    const std::string scheme = "unix:";
    const bool socket = address.rfind(scheme, 0) == 0 && address.size() > scheme.size();
    const std::size_t colon = address.rfind(':');
    const std::string port = colon == std::string::npos ? "" : address.substr(colon + 1);
    // gRPC takes port 65536 for 0, and so on.
    const bool valid = colon > 0 && !port.empty() && port.size() <= 5 &&
                       port.find_first_not_of("0123456789") == std::string::npos &&
                       std::stoi(port) <= 65535;
    if (socket || valid) return;
    throw ClientError(ErrorReason::kInvalidArgument,
                      "server address '" + address + "': must be host:port or unix:/path");
  }

  const std::string address;
  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<Stub> stub;
};

namespace {
constexpr std::chrono::milliseconds kAnswer{5000};
constexpr std::size_t kLongestReason = 200;
constexpr std::size_t kLargestFile = std::size_t{1} << 20U;

std::string read_file(const char* option, const std::string& name) {
  if (name.empty()) return {};
  std::ifstream file(name, std::ios::binary);
  std::string text(kLargestFile + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (!text.empty() && text.size() <= kLargestFile) return text;
  throw ClientError(ErrorReason::kInvalidArgument,
                    std::string(option) + " = '" + name +
                        "': must be a PEM file of at most 1 MB that can be read");
}

std::shared_ptr<grpc::ChannelCredentials> credentials(const TlsOptions& tls) {
  if (tls.certificate_file.empty() != tls.key_file.empty()) {
    throw ClientError(ErrorReason::kInvalidArgument,
                      "certificate_file, key_file: must be given together");
  }
  grpc::SslCredentialsOptions options;
  options.pem_root_certs = read_file("ca_file", tls.ca_file);
  options.pem_cert_chain = read_file("certificate_file", tls.certificate_file);
  options.pem_private_key = read_file("key_file", tls.key_file);
  return grpc::SslCredentials(options);
}

}  // namespace

Connection::Connection(const std::string& address)
    : impl_(std::make_unique<Impl>(address, grpc::InsecureChannelCredentials(), "")) {}
Connection::Connection(const std::string& address, const TlsOptions& tls)
    : impl_(std::make_unique<Impl>(address, credentials(tls), tls.server_name)) {}
Connection::~Connection() = default;

ServerInfo Connection::server_info(std::chrono::milliseconds timeout) {
  return read_as<ServerInfo>(call(*impl_->stub, &Stub::GetServerInfo, {}, timeout));
}

bool Connection::healthy(const std::string& device, std::chrono::milliseconds timeout) {
  using Request = grpc::health::v1::HealthCheckRequest;
  using Response = grpc::health::v1::HealthCheckResponse;
  grpc::TemplatedGenericStub<Request, Response> stub(impl_->channel);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + timeout);
  Request request;
  request.set_service(device);
  Response response;
  std::promise<grpc::Status> answered;
  stub.UnaryCall(&context, "/grpc.health.v1.Health/Check", {}, &request, &response,
                 [&](grpc::Status status) { answered.set_value(std::move(status)); });
  check(answered.get_future().get());
  return response.status() == Response::SERVING;
}

std::vector<DeviceInfo> Connection::devices(std::chrono::milliseconds timeout) {
  const auto answer = call(*impl_->stub, &Stub::ListDevices, {}, timeout);
  std::vector<DeviceInfo> devices;
  for (const v1::Device& device : answer.devices()) read(device, devices.emplace_back());
  return devices;
}

std::unique_ptr<Session> Connection::open(SessionOptions options) {
  auto session =
      std::make_unique<RemoteSession>(impl_->channel, impl_->address, std::move(options));
  session->open();
  return session;
}

std::unique_ptr<Watch> Connection::watch(const std::string& device, double rate_hz,
                                         std::function<void(const DeviceState&)> on_state,
                                         std::function<void(const Event&)> on_event) {
  return watch_device(impl_->channel, device, rate_hz, std::move(on_state), std::move(on_event));
}

LinkReport Connection::links(const std::string& device) {
  v1::GetLinkStatsRequest request;
  request.set_device(device);
  return read_as<LinkReport>(call(*impl_->stub, &Stub::GetLinkStats, request, kAnswer));
}

std::vector<std::string> Connection::emergency_stop(const std::string& device,
                                                    const std::string& reason) {
  v1::EmergencyStopRequest request;
  // Nothing in them may keep the stop from being read: in doubt all devices stop.
  const bool name = device.size() <= kLongestReason && wire::is_utf8(device);
  request.set_device(name ? device : "");
  const bool fits = reason.size() <= kLongestReason && wire::is_utf8(reason);
  request.set_reason(fits ? reason : "(a reason that is too long, or not UTF-8)");
  const auto answer = call(*impl_->stub, &Stub::EmergencyStop, request, kAnswer);
  return {answer.stopped().begin(), answer.stopped().end()};
}

std::vector<std::uint32_t> Connection::clear_fault(const std::string& device,
                                                   const std::vector<std::uint32_t>& faults) {
  v1::ClearFaultRequest request;
  request.set_device(device);
  request.mutable_fault_ids()->Add(faults.begin(), faults.end());
  const auto answer = call(*impl_->stub, &Stub::ClearFault, request, kAnswer);
  return {answer.cleared().begin(), answer.cleared().end()};
}

}  // namespace haptic::client
