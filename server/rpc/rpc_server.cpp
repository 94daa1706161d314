#include "server/rpc/rpc_server.hpp"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <utility>

#include "haptic/core/error.hpp"
#include "server/front/refusals.hpp"
#include "server/net/listen_address.hpp"
#include "server/rpc/credentials.hpp"
#include "server/rpc/every.hpp"
#include "server/rpc/haptic_service_impl.hpp"
#include "server/rpc/health_keeper.hpp"
#include "server/rpc/library_log.hpp"

namespace haptic::server {
namespace {

/// gRPC itself refuses larger messages, with its own words. Up to this size each call names the
/// limit (too_large).
constexpr int kLargestReceived = 4 * static_cast<int>(kLargestMessage);

/// As gRPC takes a time.
int argument_ms(core::Duration time) {
  return static_cast<int>(std::chrono::duration_cast<std::chrono::milliseconds>(time).count());
}

void set_limits(grpc::ServerBuilder& builder, const RpcConfig& config) {
  builder.SetMaxReceiveMessageSize(kLargestReceived);
  // Otherwise the kernel would let a second server share the port, and every other client.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS,
                             static_cast<int>(unopened_streams(config.max_sessions)));
  const KeepAlive& alive = config.keep_alive;
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, argument_ms(alive.ask_after));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, argument_ms(alive.answer_within));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5'000);
}

}  // namespace

class RpcServer::Impl {
 public:
  Impl(RpcConfig config, OwnerPort& owner, FactsProvider facts)
      : shared_(std::make_shared<ServiceContext>(std::move(config), owner, std::move(facts))) {
    owner.connect(shared_);
  }

  void start() {
    take_library_logs();
    const std::vector<std::string>& addresses = context_.config.listen;
    if (addresses.empty()) throw core::TransportError("no listen address");
    const Credentials credentials(context_.config.tls, context_.config.insecure_lab);
    std::vector<Protection> protections;
    protections.reserve(addresses.size());
    for (const std::string& address : addresses) {
      protections.push_back(check_listen_address(address, credentials.best()));
    }
    const std::string& udp = context_.config.udp_listen;
    if (!udp.empty()) {
      check_listen_address(udp, credentials.best());
      context_.udp = std::make_unique<UdpPort>(udp, addresses, context_.config.clock);
    }

    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    grpc::ServerBuilder builder;
    set_limits(builder, context_.config);
    std::vector<int> ports(addresses.size(), 0);
    for (std::size_t i = 0; i < addresses.size(); ++i) {
      builder.AddListeningPort(addresses[i], credentials.of(protections[i]), &ports[i]);
    }
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    for (std::size_t i = 0; i < addresses.size(); ++i) {
      if (ports[i] != 0) continue;
      if (server_) server_->Shutdown();
      server_.reset();
      throw core::TransportError("listen address '" + addresses[i] +
                                 "': cannot be bound (in use, or not an address of this host)");
    }
    if (!server_) throw core::TransportError("the gRPC server did not start");
    for (std::size_t i = 0; i < addresses.size(); ++i) {
      bound_.push_back(with_port(addresses[i], ports[i]));
      served_.push_back(bound_.back() + " (" + word(protections[i]) + ")");
      std::string weak = weakness(bound_.back(), protections[i]);
      if (!weak.empty()) context_.add_weakness(std::move(weak));
    }
    if (context_.udp) context_.udp->start();
    health_ = std::make_unique<HealthKeeper>(*server_->GetHealthCheckService(), context_.owner());
    const auto a_fifth =
        std::chrono::duration_cast<std::chrono::milliseconds>(context_.config.open_within / 5);
    overdue_ = std::make_unique<Every>(a_fifth,
                                       [this] { context_.end_overdue(context_.config.clock({})); });
  }

  void shutdown(core::Duration grace) {
    if (!server_) return;
    overdue_.reset();
    health_.reset();
    context_.streams.close_all();
    server_->Shutdown(std::chrono::system_clock::now() +
                      std::chrono::duration_cast<std::chrono::system_clock::duration>(grace));
    server_.reset();
    context_.streams.wait_until_gone();
    context_.udp.reset();  // no session has a path any more
    bound_.clear();
    served_.clear();
  }

  [[nodiscard]] std::vector<std::string> bound() const { return bound_; }
  [[nodiscard]] std::vector<std::string> served() const { return served_; }
  [[nodiscard]] std::vector<std::string> weaknesses() const { return context_.weaknesses(); }
  [[nodiscard]] std::uint16_t udp_port() const {
    return context_.udp ? context_.udp->port() : std::uint16_t{0};
  }
  [[nodiscard]] unsigned sessions() const { return context_.sessions(); }
  [[nodiscard]] std::vector<std::pair<std::string, std::uint64_t>> dropped_datagrams() const {
    std::vector<std::pair<std::string, std::uint64_t>> answer;
    if (!context_.udp) return answer;
    for (std::size_t i = 1; i < wire::kRejections; ++i) {
      const auto why = static_cast<wire::Rejection>(i);
      answer.emplace_back(wire::name(why), context_.udp->dropped(why));
    }
    return answer;
  }

 private:
  const std::shared_ptr<ServiceContext> shared_;  ///< the owner may be calling it still
  ServiceContext& context_{*shared_};
  HapticServiceImpl service_{context_};
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<HealthKeeper> health_;
  std::unique_ptr<Every> overdue_;
  std::vector<std::string> bound_;
  std::vector<std::string> served_;
};

RpcServer::RpcServer(RpcConfig config, OwnerPort& owner, FactsProvider facts)
    : impl_(std::make_unique<Impl>(std::move(config), owner, std::move(facts))) {}

RpcServer::~RpcServer() {
  impl_->shutdown(std::chrono::seconds(1));
}

void RpcServer::start() {
  impl_->start();
}

std::vector<std::string> RpcServer::bound_addresses() const {
  return impl_->bound();
}

std::vector<std::string> RpcServer::served() const {
  return impl_->served();
}

std::vector<std::string> RpcServer::weaknesses() const {
  return impl_->weaknesses();
}

std::uint16_t RpcServer::udp_port() const {
  return impl_->udp_port();
}

unsigned RpcServer::sessions() const {
  return impl_->sessions();
}

std::vector<std::pair<std::string, std::uint64_t>> RpcServer::dropped_datagrams() const {
  return impl_->dropped_datagrams();
}

void RpcServer::shutdown(core::Duration grace) {
  impl_->shutdown(grace);
}

}  // namespace haptic::server
