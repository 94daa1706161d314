#include "server/front_app.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "server/metrics/metrics.hpp"
#include "server/metrics/metrics_port.hpp"
#include "server/net/tls_files.hpp"
#include "server/rpc/rpc_server.hpp"

namespace haptic::server {
namespace {

constexpr core::Duration kCallsGrace = std::chrono::seconds(1);

RpcConfig rpc_config(const Scene& scene, bool insecure_lab) {
  RpcConfig config;
  config.tls = scene.server.tls;
  config.insecure_lab = insecure_lab;
  config.listen = scene.server.listen;
  config.max_sessions = scene.server.max_sessions;
  config.period = scene.loop.period;
  config.udp_listen = scene.server.udp_listen;
  return config;
}

}  // namespace

FrontApp::FrontApp(const Scene& scene, bool insecure_lab, FrontSources sources)
    : scene_name_(scene.name),
      metrics_listen_(scene.server.metrics_listen),
      insecure_lab_(insecure_lab),
      sources_(std::move(sources)),
      rpc_(std::make_unique<RpcServer>(rpc_config(scene, insecure_lab), *sources_.owner,
                                       sources_.facts)) {}

FrontApp::~FrontApp() {
  stop();
}

void FrontApp::check(const Scene& scene) {
  if (scene.server.tls) static_cast<void>(load_tls(*scene.server.tls));
}

void FrontApp::start() {
  try {
    rpc_->start();
    listen_for_scrapes();
  } catch (...) {
    stop();
    throw;
  }
  if (rpc_->udp_port() != 0) spdlog::info("UDP path on port {}", rpc_->udp_port());
  for (const std::string& address : rpc_->served()) {
    spdlog::info("serving '{}' on {}", scene_name_, address);
  }
  const auto level = insecure_lab_ ? spdlog::level::warn : spdlog::level::info;
  for (const std::string& weakness : rpc_->weaknesses()) {
    spdlog::log(level, "not protected: {}", weakness);
  }
}

void FrontApp::stop() {
  metrics_.reset();  // scrapes ask everything below
  if (rpc_) rpc_->shutdown(kCallsGrace);
}

std::vector<std::string> FrontApp::addresses() const {
  return rpc_->bound_addresses();
}

/// In the order of RpcServer::dropped_datagrams(); last the connections that were cut.
FrontCounters FrontApp::counted() const {
  FrontCounters own{};
  const auto dropped = rpc_->dropped_datagrams();
  for (std::size_t i = 0; i < dropped.size(); ++i) own.at(i) = dropped[i].second;
  own.back() = rpc_->connections().second;
  return sources_.count ? sources_.count(own) : own;
}

void FrontApp::listen_for_scrapes() {
  if (metrics_listen_.empty()) return;
  MetricsSources sources;
  sources.owner = sources_.owner;
  sources.totals = sources_.totals;
  sources.facts = sources_.facts;
  sources.dropped_datagrams = [this] {
    auto dropped = rpc_->dropped_datagrams();
    const FrontCounters all = counted();
    for (std::size_t i = 0; i < dropped.size(); ++i) dropped[i].second = all.at(i);
    return dropped;
  };
  sources.connections = [this] { return std::pair(rpc_->connections().first, counted().back()); };
  metrics_ = std::make_unique<MetricsPort>(
      metrics_listen_, insecure_lab_, [from = std::move(sources)] { return metrics_text(from); });
  spdlog::info("metrics on port {}", metrics_->port());
}

std::uint16_t FrontApp::metrics_port() const {
  return metrics_ ? metrics_->port() : std::uint16_t{0};
}

}  // namespace haptic::server
