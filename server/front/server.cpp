#include "server/front/server.hpp"

#include <algorithm>

#include "haptic/core/error.hpp"
#include "server/front/grpc/rpc_server.hpp"
#include "server/front/net/listen_address.hpp"
#include "server/front/web/web_server.hpp"

namespace haptic::server {
namespace {

using Scope = WebServer::Scope;

/// The best protection that an address can have.
Protection best_protection(const ServiceConfig& config) {
  if (!config.tls) {
    return config.insecure_lab ? Protection::kInsecureLab : Protection::kThisHost;
  }
  return config.tls->client_ca.empty() ? Protection::kTls : Protection::kMutualTls;
}

/// Those for browsers, then the metrics', which is never encrypted.
std::vector<WebServer::Address> web_addresses(const ServiceConfig& config) {
  std::vector<WebServer::Address> addresses;
  if (config.web) {
    // A token takes the place of a certificate.
    const Protection best = config.tls ? Protection::kTls : best_protection(config);
    for (const std::string& address : config.web->listen) {
      addresses.push_back({address, check_listen_address(address, best), Scope::kAll});
    }
  }
  if (config.metrics_listen.empty()) return addresses;
  if (!unix_path(config.metrics_listen).empty()) {
    throw core::TransportError("metrics address '" + config.metrics_listen +
                               "': must be host:port (Prometheus asks by TCP)");
  }
  const Protection best = config.insecure_lab ? Protection::kInsecureLab : Protection::kThisHost;
  addresses.push_back(
      {config.metrics_listen, check_listen_address(config.metrics_listen, best), Scope::kMetrics});
  return addresses;
}

}  // namespace

FrontServer::FrontServer(ServiceConfig config, OwnerPort& owner, FactsProvider facts,
                         WebContent content)
    : context_(std::make_shared<ServiceContext>(std::move(config), owner, std::move(facts))),
      content_(std::move(content)),
      rpc_(std::make_unique<RpcServer>(*context_)) {
  owner.connect(context_);
}

FrontServer::~FrontServer() {
  shutdown(std::chrono::seconds(1));
}

void FrontServer::start() {
  try {
    serve();
  } catch (...) {
    shutdown(core::Duration(0));
    throw;
  }
}

void FrontServer::serve() {
  ServiceContext& context = *context_;
  const ServiceConfig& config = context.config;
  if (config.listen.empty()) throw core::TransportError("no listen address");
  // Before anything of gRPC runs, which aborts when it gets no thread or descriptor.
  const ConnectionLimits limits = within_descriptors(config.connections);
  require_threads();
  const Protection best = best_protection(config);
  std::vector<Protection> protections;
  for (const std::string& address : config.listen) {
    protections.push_back(check_listen_address(address, best));
  }
  if (!config.udp_listen.empty()) {
    check_listen_address(config.udp_listen, best);
    context.udp = std::make_unique<UdpPort>(config.udp_listen, config.listen, config.clock);
  }
  std::vector<WebServer::Address> web = web_addresses(config);
  std::vector<std::string> addresses = config.listen;
  for (const auto& address : web) addresses.push_back(address.bound);
  context.connections = std::make_unique<Connections>(addresses, limits);
  const std::vector<int>& ports = context.connections->ports();
  for (std::size_t i = 0; i < ports.size(); ++i) {
    bound_.push_back(with_port(addresses[i], ports[i]));
    if (i < protections.size()) {
      served_.push_back(bound_.back() + " (" + word(protections[i]) + ")");
      std::string weak = weakness(bound_.back(), protections[i]);
      if (!weak.empty()) context.add_weakness(std::move(weak));
      continue;
    }
    WebServer::Address& address = web[i - protections.size()];
    address.bound = bound_.back();
    if (address.scope == Scope::kMetrics) continue;
    served_.push_back(address.bound + " for browsers (" + word(address.protection) + ", by token)");
    if (address.protection == Protection::kInsecureLab) {
      context.add_weakness("HTTP without TLS on " + address.bound +
                           " (--insecure-lab): every host on that network may read tokens, and "
                           "move the device with them");
    }
  }
  rpc_->start(protections);
  if (!web.empty()) {
    web_ = std::make_unique<WebServer>(context, content_, std::move(web));
    web_->start();
  }
  if (context.udp) context.udp->start();
  context.connections->start([this, n = protections.size()](std::size_t address, int descriptor,
                                                            std::shared_ptr<Account> account) {
    if (address < n) return rpc_->take(address, descriptor);
    web_->take(address - n, descriptor, std::move(account));
  });
}

void FrontServer::shutdown(core::Duration grace) {
  if (context_->connections) context_->connections->close(grace / 2);
  context_->streams.close_all();
  rpc_->stop(grace);
  if (web_) web_->stop(grace / 2);
  context_->streams.wait_until_gone();
  context_->connections.reset();
  web_.reset();
  context_->udp.reset();  // no session has a path any more
  bound_.clear();
  served_.clear();
}

std::string FrontServer::web_address() const {
  const ServiceConfig& config = context_->config;
  if (bound_.empty() || !config.web) return {};
  return bound_[config.listen.size()];
}

std::uint16_t FrontServer::metrics_port() const {
  if (bound_.empty() || context_->config.metrics_listen.empty()) return 0;
  const std::string& address = bound_.back();
  return static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
}

std::pair<std::size_t, std::uint64_t> FrontServer::connections() const {
  const auto& door = context_->connections;
  return door ? std::pair(door->open(), door->cut()) : std::pair<std::size_t, std::uint64_t>();
}

std::uint16_t FrontServer::udp_port() const {
  return context_->udp ? context_->udp->port() : std::uint16_t{0};
}

std::vector<std::pair<std::string, std::uint64_t>> FrontServer::dropped_datagrams() const {
  std::vector<std::pair<std::string, std::uint64_t>> answer;
  if (!context_->udp) return answer;
  for (std::size_t i = 1; i < wire::kRejections; ++i) {
    const auto why = static_cast<wire::Rejection>(i);
    answer.emplace_back(wire::name(why), context_->udp->dropped(why));
  }
  return answer;
}

}  // namespace haptic::server
