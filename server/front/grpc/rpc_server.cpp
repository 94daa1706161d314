#include "server/front/grpc/rpc_server.hpp"

#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <spdlog/spdlog.h>

#include <mutex>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/front/grpc/haptic_service_impl.hpp"
#include "server/front/net/protection.hpp"
#include "server/front/session/refusals.hpp"

namespace haptic::server {
namespace {

using std::chrono::milliseconds;

/// gRPC itself refuses larger messages, with its own words. Up to this size each call names the
/// limit (too_large).
constexpr int kLargestReceived = 4 * static_cast<int>(kLargestMessage);
/// TLS and HTTP/2 have begun by then, or the connection is closed.
constexpr std::chrono::seconds kHandshake{10};
constexpr int kReflectionThreads = 8;
constexpr int kReadChunk = 4096;
/// Milliseconds, in which gRPC takes a time.
int argument_ms(core::Duration time) {
  return static_cast<int>(std::chrono::duration_cast<milliseconds>(time).count());
}

void set_limits(grpc::ServerBuilder& builder, const ServiceContext& context) {
  builder.SetMaxReceiveMessageSize(kLargestReceived);
  // gRPC inflates a message before it looks at its size.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.AddChannelArgument(GRPC_ARG_ENABLE_PER_MESSAGE_DECOMPRESSION, 0);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS,
                             static_cast<int>(calls_of_connection(context.config.max_sessions)));
  // A chunk is parsed whole before anything can end its connection, and may begin a stream with
  // every 20 bytes.
  builder.AddChannelArgument(GRPC_ARG_TCP_READ_CHUNK_SIZE, kReadChunk);
  builder.AddChannelArgument(GRPC_ARG_TCP_MIN_READ_CHUNK_SIZE, kReadChunk);
  builder.AddChannelArgument(GRPC_ARG_TCP_MAX_READ_CHUNK_SIZE, kReadChunk);
  // Messages are small: a window that grows with the link's speed only lets more wait in memory.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, argument_ms(kHandshake));
  // Server reflection has a thread for each of its streams. Beyond these it is refused.
  grpc::ResourceQuota quota("hapticd");
  quota.SetMaxThreads(kReflectionThreads);
  builder.SetResourceQuota(quota);
  using Sync = grpc::ServerBuilder::SyncServerOption;
  builder.SetSyncServerOption(Sync::NUM_CQS, 1);
  builder.SetSyncServerOption(Sync::MIN_POLLERS, 1);
  builder.SetSyncServerOption(Sync::MAX_POLLERS, 1);
  const KeepAlive& alive = context.limits.keep_alive;
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, argument_ms(alive.ask_after));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, argument_ms(alive.answer_within));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  // Clients ask once a second while nothing comes; one that asks more often is disconnected.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 500);
}

/// Sends the messages of gRPC and protobuf to the server's log: by themselves they would write to
/// standard error and wait for its reader. They are debug, because the server reports in its own
/// words why a call or a start failed, and the sender of a wrong message gets an answer.
void take_library_logs() {
  gpr_set_log_function([](gpr_log_func_args* word) { spdlog::debug("gRPC: {}", word->message); });
  google::protobuf::SetLogHandler([](google::protobuf::LogLevel level, const char* /*file*/,
                                     int /*line*/, const std::string& message) {
    const bool fatal = level == google::protobuf::LOGLEVEL_FATAL;
    spdlog::log(fatal ? spdlog::level::err : spdlog::level::debug, "protobuf: {}", message);
  });
}

std::shared_ptr<grpc::ServerCredentials> tls_credentials(TlsFiles files) {
  grpc::SslServerCredentialsOptions options(
      files.client_ca.empty() ? GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE
                              : GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  options.pem_root_certs = std::move(files.client_ca);
  options.pem_key_cert_pairs.push_back({std::move(files.key), std::move(files.certificate)});
  return grpc::SslServerCredentials(options);
}

}  // namespace

/// The parts that need gRPC's headers.
struct RpcServer::Grpc {
  Grpc(ServiceContext& shared, std::optional<TlsFiles> read)
      : context(shared), tls(std::move(read)) {}

  ServiceContext& context;
  std::optional<TlsFiles> tls;
  const std::unique_ptr<grpc::Service> service{haptic_service(context)};
  std::vector<std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor>> acceptors{};
  std::unique_ptr<grpc::Server> server{};
  std::mutex mutex{};
  bool healthy{false};  ///< under the mutex: it serves, and is to tell the health of the devices
};

RpcServer::RpcServer(ServiceContext& context, std::optional<TlsFiles> tls)
    : grpc_(std::make_unique<Grpc>(context, std::move(tls))) {}

RpcServer::~RpcServer() {
  stop(std::chrono::seconds(1));
}

void RpcServer::start() {
  take_library_logs();
  ServiceContext& context = grpc_->context;
  const auto tls = grpc_->tls ? tls_credentials(std::move(*grpc_->tls)) : nullptr;
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  set_limits(builder, context);
  for (const FrontConfig::Address& address : context.config.addresses) {
    if (address.use != FrontConfig::Use::kGrpc) break;
    grpc_->acceptors.push_back(builder.experimental().AddExternalConnectionAcceptor(
        grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
        encrypts(address.protection) ? tls : grpc::InsecureServerCredentials()));
  }
  builder.RegisterService(grpc_->service.get());
  grpc_->server = builder.BuildAndStart();
  if (!grpc_->server) throw core::TransportError("the gRPC server did not start");
  grpc_->healthy = true;
  report_health();
}

void RpcServer::take(std::size_t address, int descriptor) {
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
  connection.listener_fd = -1;
  connection.fd = descriptor;
  grpc_->acceptors[address]->HandleNewConnection(&connection);
}

void RpcServer::report_health() {
  const std::lock_guard lock(grpc_->mutex);
  if (!grpc_->healthy) return;
  grpc::HealthCheckServiceInterface& health = *grpc_->server->GetHealthCheckService();
  const ServiceContext& context = grpc_->context;
  for (std::size_t i = 0; i < context.owner().devices().size(); ++i) {
    health.SetServingStatus(context.facts(i).name, context.serving(i));
  }
  health.SetServingStatus("", context.serving());
}

void RpcServer::stop(core::Duration grace) {
  if (!grpc_->server) return;
  {
    const std::lock_guard lock(grpc_->mutex);
    grpc_->healthy = false;
  }
  grpc_->server->GetHealthCheckService()->SetServingStatus(false);
  grpc_->server->Shutdown(std::chrono::system_clock::now() +
                          std::chrono::duration_cast<std::chrono::system_clock::duration>(grace));
  grpc_->server.reset();
}

}  // namespace haptic::server
