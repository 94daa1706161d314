#include "server/front/server.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <condition_variable>
#include <ctime>
#include <mutex>
#include <span>

#include "server/base/steady_now.hpp"
#include "server/base/thread_setup.hpp"
#include "server/front/grpc/rpc_server.hpp"
#include "server/front/metrics/metrics.hpp"
#include "server/front/net/protection.hpp"
#include "server/front/web/web_server.hpp"

namespace haptic::server {
namespace {

using Use = FrontConfig::Use;

/// With Calls::kPatience it is the 500 ms of proto/README.md, "Every limit".
constexpr std::chrono::milliseconds kLookEvery{100};

/// The log tells of a certificate that ends.
constexpr std::time_t kTellEvery = 24 * 3600;

bool serves(const FrontConfig& config, Use use) {
  return std::any_of(config.addresses.begin(), config.addresses.end(),
                     [use](const FrontConfig::Address& address) { return address.use == use; });
}

}  // namespace

FrontServer::FrontServer(FrontStart start, OwnerPort& owner, FrontSources sources,
                         ServiceLimits limits)
    : sources_(std::move(sources)),
      context_(std::make_shared<ServiceContext>(std::move(start.config), owner, sources_.facts,
                                                std::move(limits))),
      content_{sources_.page, [this] { return metrics(); }} {
  std::span<const Descriptor> files = start.files;
  std::optional<TlsFiles> tls;
  if (config().tls) {
    tls = read_tls(*config().tls, files);
    ends_ = tls->ends;
    files = files.subspan(tls->client_ca.empty() ? 2 : 3);
  }
  // With tokens also where nothing is served: a check reads them.
  if (config().web || serves(config(), Use::kMetrics)) {
    web_ = std::make_unique<WebServer>(*context_, content_, tls, files);
  }
  rpc_ = std::make_unique<RpcServer>(*context_, std::move(tls));
  take(std::move(start.sockets));
  owner.connect(context_);
}

void FrontServer::take(std::vector<Descriptor> sockets) {
  sockets_ = std::move(sockets);
  if (sockets_.empty() || config().udp_listen.empty()) return;
  std::vector<std::string> streams;
  for (const FrontConfig::Address& address : config().addresses) {
    if (address.use == Use::kGrpc) streams.push_back(address.name);
  }
  context_->udp =
      std::make_unique<UdpPort>(std::move(sockets_.back()), streams, context_->limits.clock);
}

FrontServer::~FrontServer() {
  stop(std::chrono::seconds(1));
}

void FrontServer::start() {
  try {
    serve();
  } catch (...) {
    stop(core::Duration(0));
    throw;
  }
  say_what_is_served();
}

void FrontServer::serve() {
  ServiceContext& context = *context_;
  // Before anything of gRPC runs, which aborts when it gets no thread or descriptor.
  const ConnectionLimits limits = within_descriptors(context.limits.connections);
  require_threads();
  std::vector<Connections::Listener> listeners;
  for (std::size_t i = 0; i < config().addresses.size(); ++i) {
    const FrontConfig::Address& address = config().addresses[i];
    for (std::uint32_t n = 0; n < address.sockets; ++n) {
      listeners.push_back({std::move(sockets_.at(listeners.size())), i});
    }
  }
  context.connections = std::make_unique<Connections>(std::move(listeners), limits);
  rpc_->start();
  looks_ = std::jthread([this](const std::stop_token& over) { look_after(over); });
  if (web_) web_->start();
  if (context.udp) context.udp->start();
  context.connections->start(
      [this](std::size_t address, int descriptor, std::shared_ptr<Account> account) {
        if (config().addresses[address].use == Use::kGrpc) return rpc_->take(address, descriptor);
        web_->take(address, descriptor, std::move(account));
      });
}

void FrontServer::look_after(const std::stop_token& over) {
  set_thread_up("look after");
  const core::Duration every =
      std::min<core::Duration>(kLookEvery, context_->limits.open_within / 5);
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any wakes;
  std::time_t told = 0;
  do {
    if (const std::time_t now = std::time(nullptr); now - told >= kTellEvery || now < told) {
      told = now;
      for (const std::string& sentence : warnings()) spdlog::warn(sentence);
    }
    rpc_->report_health();
    context_->end_overdue(context_->limits.clock({}));
    context_->give_up(steady_now());
  } while (!wakes.wait_for(lock, over, every, [&] { return over.stop_requested(); }));
}

void FrontServer::stop(core::Duration grace) {
  if (context_->connections) context_->connections->close(grace / 2);
  context_->streams.close_all();
  if (rpc_) rpc_->stop(grace);
  if (web_) web_->stop(grace / 2);
  context_->streams.wait_until_gone();
  looks_ = {};  // no call waits for an answer any more
  context_->connections.reset();
  web_.reset();
  context_->udp.reset();  // no session has a path any more
}

std::vector<std::string> FrontServer::served() const {
  std::vector<std::string> all;
  for (const FrontConfig::Address& address : config().addresses) {
    const std::string protection = word(address.protection);
    if (address.use == Use::kGrpc) all.push_back(address.name + " (" + protection + ")");
    if (address.use == Use::kWeb) {
      all.push_back(address.name + " for browsers (" + protection + ", by token)");
    }
  }
  return all;
}

void FrontServer::say_what_is_served() const {
  if (!config().udp_listen.empty())
    spdlog::info("UDP path on port {}", port_of(config().udp_listen));
  for (const std::string& address : served()) {
    spdlog::info("serving '{}' on {}", config().scene, address);
  }
  for (const FrontConfig::Address& address : config().addresses) {
    if (address.use == Use::kMetrics) spdlog::info("metrics on port {}", port_of(address.name));
  }
  const auto level = config().insecure_lab ? spdlog::level::warn : spdlog::level::info;
  for (const std::string& sentence : weaknesses(config())) {
    spdlog::log(level, "not protected: {}", sentence);
  }
}

std::vector<std::string> FrontServer::warnings() const {
  return ending(ends_, std::time(nullptr));
}

std::pair<std::size_t, std::uint64_t> FrontServer::connections() const {
  const auto& door = context_->connections;
  return door ? std::pair(door->open(), door->cut()) : std::pair<std::size_t, std::uint64_t>();
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

/// In the order of dropped_datagrams(); last the connections that were cut.
FrontCounters FrontServer::counted() const {
  FrontCounters own{};
  const auto dropped = dropped_datagrams();
  for (std::size_t i = 0; i < dropped.size(); ++i) own.at(i) = dropped[i].second;
  own.back() = connections().second;
  return sources_.count ? sources_.count(own) : own;
}

std::string FrontServer::metrics() const {
  const FrontCounters all = counted();
  MetricsSources sources{.owner = &context_->owner(),
                         .totals = sources_.totals,
                         .facts = sources_.facts,
                         .dropped_datagrams = dropped_datagrams(),
                         .connections = {connections().first, all.back()}};
  for (std::size_t i = 0; i < sources.dropped_datagrams.size(); ++i) {
    sources.dropped_datagrams[i].second = all.at(i);
  }
  return metrics_text(sources);
}

}  // namespace haptic::server
