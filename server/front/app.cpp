#include "server/front/app.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "server/front/metrics/metrics.hpp"
#include "server/front/net/tls_files.hpp"
#include "server/front/server.hpp"

namespace haptic::server {
namespace {

constexpr core::Duration kCallsGrace = std::chrono::seconds(1);

ServiceConfig service_config(const Scene& scene, bool insecure_lab) {
  ServiceConfig config;
  config.tls = scene.server.tls;
  config.insecure_lab = insecure_lab;
  config.listen = scene.server.listen;
  config.max_sessions = scene.server.max_sessions;
  config.period = scene.loop.period;
  config.udp_listen = scene.server.udp_listen;
  config.web = scene.server.web;
  config.metrics_listen = scene.server.metrics_listen;
  return config;
}

}  // namespace

FrontApp::FrontApp(const Scene& scene, bool insecure_lab, FrontSources sources, Page page)
    : scene_name_(scene.name),
      insecure_lab_(insecure_lab),
      sources_(std::move(sources)),
      server_(std::make_unique<FrontServer>(
          service_config(scene, insecure_lab), *sources_.owner, sources_.facts,
          WebContent{std::move(page), [this] { return metrics(); }})) {}

FrontApp::~FrontApp() {
  stop();
}

void FrontApp::check(const Scene& scene) {
  if (scene.server.tls) static_cast<void>(load_tls(*scene.server.tls));
}

void FrontApp::start() {
  try {
    server_->start();
  } catch (...) {
    stop();
    throw;
  }
  if (server_->udp_port() != 0) spdlog::info("UDP path on port {}", server_->udp_port());
  for (const std::string& address : server_->served()) {
    spdlog::info("serving '{}' on {}", scene_name_, address);
  }
  if (metrics_port() != 0) spdlog::info("metrics on port {}", metrics_port());
  const auto level = insecure_lab_ ? spdlog::level::warn : spdlog::level::info;
  for (const std::string& weakness : server_->weaknesses()) {
    spdlog::log(level, "not protected: {}", weakness);
  }
}

void FrontApp::stop() {
  server_->shutdown(kCallsGrace);
}

std::vector<std::string> FrontApp::addresses() const {
  return server_->bound_addresses();
}

/// In the order of FrontServer::dropped_datagrams(); last the connections that were cut.
FrontCounters FrontApp::counted() const {
  FrontCounters own{};
  const auto dropped = server_->dropped_datagrams();
  for (std::size_t i = 0; i < dropped.size(); ++i) own.at(i) = dropped[i].second;
  own.back() = server_->connections().second;
  return sources_.count ? sources_.count(own) : own;
}

std::string FrontApp::metrics() const {
  MetricsSources sources;
  sources.owner = sources_.owner;
  sources.totals = sources_.totals;
  sources.facts = sources_.facts;
  sources.dropped_datagrams = [this] {
    auto dropped = server_->dropped_datagrams();
    const FrontCounters all = counted();
    for (std::size_t i = 0; i < dropped.size(); ++i) dropped[i].second = all.at(i);
    return dropped;
  };
  sources.connections = [this] {
    return std::pair(server_->connections().first, counted().back());
  };
  return metrics_text(sources);
}

std::uint16_t FrontApp::metrics_port() const {
  return server_->metrics_port();
}

}  // namespace haptic::server
