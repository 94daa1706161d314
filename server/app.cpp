#include "server/app.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "hw/open_device.hpp"
#include "server/rpc/rpc_server.hpp"
#include "server/rpc/steady_now.hpp"
#include "server/telemetry/event_log.hpp"
#include "server/telemetry/recorder.hpp"

namespace haptic::server {

namespace {

using std::chrono::milliseconds;

/// WIRE 4: always shorter than a board's watchdog, longer where the host may hold a tick up.
constexpr core::Duration kLateFaultRealtime = milliseconds(8);
constexpr core::Duration kLateFaultElsewhere = milliseconds(20);
constexpr core::Duration kLongestRelease = std::chrono::seconds(3);
constexpr core::Duration kCallsGrace = std::chrono::seconds(1);

}  // namespace

class App::Rpc : public RpcServer {
 public:
  using RpcServer::RpcServer;
};

const char* version() noexcept {
  return HAPTIC_VERSION;
}

App::App(Scene scene, AppOptions options) : scene_(std::move(scene)), options_(options) {}

App::~App() {
  stop();
}

void App::start() {
  started_ = steady_now();
  loop_ = std::make_unique<Loop>(scene_.loop.period);
  realtime_ = loop_->prepare({options_.realtime, scene_.loop.priority, scene_.loop.cpu});
  const std::string line = "real-time: " + realtime_.grade + " - " + realtime_.explanation;
  if (realtime_.grade == "real-time") {
    spdlog::info(line);
  } else {
    spdlog::warn(line);
  }
  running_ = true;
  open_devices();

  std::vector<DeviceUnit*> units;
  for (const auto& unit : units_) units.push_back(unit.get());
  telemetry_ = std::make_unique<Telemetry>(units);
  std::vector<DeviceSessions*> sessions;
  for (std::size_t i = 0; i < units.size(); ++i) {
    sessions_.push_back(std::make_unique<DeviceSessions>(
        *units[i], *telemetry_, i,
        SessionRules{scene_.server.lease_timeout, scene_.devices[i].fresh_end}));
    sessions.push_back(sessions_.back().get());
    listeners_.push_back(std::make_unique<EventLog>(units[i]->name()));
    telemetry_->add(i, listeners_.back().get());
    if (scene_.record) {
      auto comparison = scene_.record->compare_renderers
                            ? std::make_unique<RendererComparison>(scene_.devices[i].kinematics,
                                                                   scene_.devices[i].settings)
                            : nullptr;
      listeners_.push_back(std::make_unique<Recorder>(
          record_file(scene_.record->file, units[i]->name(), units.size()),
          scene_.devices[i].kinematics, std::move(comparison)));
      telemetry_->add(i, listeners_.back().get());
    }
  }
  rpc_ = std::make_unique<Rpc>(
      RpcConfig{scene_.server.listen, scene_.server.max_sessions, scene_.loop.period}, sessions,
      *telemetry_, [this] { return facts(); });
  telemetry_->start();
  loop_->run(units, *telemetry_);
  rpc_->start();
  for (const std::string& address : rpc_->bound_addresses()) spdlog::info("serving {}", address);
}

void App::open_devices() {
  for (const DeviceScene& scene : scene_.devices) {
    std::unique_ptr<hw::Device> device = hw::open_device(scene.source, scene.kinematics);
    core::PipelineConfig config;
    config.kinematics = scene.kinematics;
    config.device = device->info().limits;
    config.scene = scene.settings;
    config.loop_late_fault = scene_.loop.loop_late_fault.value_or(
        realtime_.sched_fifo ? kLateFaultRealtime : kLateFaultElsewhere);
    config.late_bucket_full = scene_.loop.late_bucket_full;
    spdlog::info("{}: {} ({})", scene.name, device->info().model, device->info().kind);
    units_.push_back(
        std::make_unique<DeviceUnit>(scene.name, std::move(device), std::move(config)));
  }
}

void App::stop() {
  if (!running_) return;
  running_ = false;
  for (const auto& sessions : sessions_) sessions->begin_closing();
  loop_->finish(kLongestRelease);
  if (rpc_) rpc_->shutdown(kCallsGrace);
  if (telemetry_) telemetry_->stop();
  for (const auto& unit : units_) unit->device().close();
  rpc_.reset();
  sessions_.clear();
  telemetry_.reset();
  listeners_.clear();
}

std::vector<std::string> App::addresses() const {
  return rpc_ ? rpc_->bound_addresses() : std::vector<std::string>{};
}

LoopFacts App::loop_facts() const {
  LoopFacts out = loop_ ? loop_->facts() : LoopFacts{};
  for (const auto& unit : units_) out.records_dropped += unit->records.dropped();
  return out;
}

ServerFacts App::facts() const {
  return {version(), scene_.name, realtime_, loop_facts(), steady_now() - started_};
}

}  // namespace haptic::server
