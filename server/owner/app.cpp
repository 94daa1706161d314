#include "server/owner/app.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "hw/device_config.hpp"
#include "server/base/log.hpp"
#include "server/base/steady_now.hpp"
#include "server/base/version.hpp"
#include "server/owner/telemetry/tick_metrics.hpp"

namespace haptic::server {
namespace {

/// Together with 200 ms per device for close() they stay below the 5 s of
/// proto/README.md#states-of-a-device. A release takes fade_end - hold_end, 80 ms by default.
constexpr core::Duration kLongestRelease = std::chrono::milliseconds(2500);

void log_grant(const RealtimeFacts& grant) {
  const auto level = grant.grade == "real-time" ? spdlog::level::info : spdlog::level::warn;
  spdlog::log(level, "real-time grade '{}': {}", grant.grade.view(), grant.explanation.view());
}

std::unique_ptr<RendererComparison> comparison(const RecordScene& record,
                                               const DeviceScene& device) {
  if (!record.compare_renderers) return nullptr;
  return std::make_unique<RendererComparison>(device.pipeline.kinematics,
                                              device.pipeline.projection);
}

/// The link's final counts, when nothing is under way any more.
void log_link(const std::string& name, const std::vector<hw::LinkCount>& counts) {
  if (counts.empty()) return;
  std::string text;
  for (const hw::LinkCount& n : counts) {
    text += text.empty() ? "" : ", ";
    text += std::string(n.end) + ' ' + n.what + ' ' + std::to_string(n.frames);
  }
  spdlog::info("{}: link closed, frames: {}", name, text);
}

template <typename T>
std::vector<T*> pointers(const std::vector<std::unique_ptr<T>>& owners) {
  std::vector<T*> answer;
  answer.reserve(owners.size());
  for (const auto& owner : owners) answer.push_back(owner.get());
  return answer;
}

}  // namespace

App::App(Scene scene, AppOptions options, MakeFront make_front)
    : scene_(std::move(scene)), options_(options), make_front_(std::move(make_front)) {}

App::~App() {
  stop();
}

void App::start() {
  try {
    started_ = steady_now();
    const LoopScene& loop = scene_.loop;
    loop_ = std::make_unique<Loop>(
        RealtimeRequest{options_.realtime, loop.priority, loop.cpu, loop.loop_late_fault},
        loop.period);
    realtime_ = loop_->grant();
    log_grant(realtime_.facts);
    if (realtime_.facts.sched_fifo) log_in_realtime();
    open_devices();
    telemetry_ = std::make_unique<Telemetry>(pointers(units_));
    telemetry_->allow_watching(realtime_.facts.sched_fifo &&
                               std::thread::hardware_concurrency() > 1);
    if (realtime_.may_keep_awake) {
      telemetry_->on_watched([](bool awake) { real_host().keep_awake(awake); });
    }
    listen_to_devices();
    front_ = make_front_(*this);
    front_->start();
    telemetry_->start();
    loop_->begin(pointers(units_), telemetry_->bell(), pacing_samples());
  } catch (...) {
    stop();
    throw;
  }
}

void App::open_devices() {
  for (const DeviceScene& scene : scene_.devices) {
    std::unique_ptr<hw::Device> device =
        scene.source->open(scene.pipeline.kinematics, realtime_.loop_late_fault);
    check_force_control(scene.force_control, device->info());
    if (scene.name == scene_.loop.paced_by) check_pacing(scene_.loop, *device);
    core::PipelineConfig config = pipeline_config(scene, device->info().limits);
    config.loop_late_fault = realtime_.loop_late_fault;
    spdlog::info("{}: {} ({})", scene.name, device->info().model, device->info().kind);
    for (const std::string& note : device->info().notes) spdlog::warn("{}: {}", scene.name, note);
    units_.push_back(
        std::make_unique<DeviceUnit>(scene.name, std::move(device), std::move(config)));
  }
}

hw::SampleSignal* App::pacing_samples() {
  for (const auto& unit : units_) {
    if (unit->name() == scene_.loop.paced_by) return unit->device().sample_signal();
  }
  return nullptr;
}

void App::listen_to_devices() {
  owner_ = std::make_unique<Owner>(*telemetry_, scene_.server.max_sessions);
  event_log_ = std::make_shared<EventLog>(*owner_);
  owner_->connect(event_log_);
  if (!scene_.server.metrics_listen.empty() || scene_.server.web) {
    tick_metrics_ = std::make_shared<TickMetrics>(units_.size());
    owner_->count_into(tick_metrics_);
  }
  for (std::size_t i = 0; i < units_.size(); ++i) {
    const DeviceScene& device = scene_.devices[i];
    owner_->add(*units_[i], SessionRules{scene_.server.lease_timeout, device.fresh_end,
                                         device.tracker_fresh_end});
    if (!scene_.record) continue;
    const NewFile file = create_file(record_file(scene_, i), scene_.record->overwrite);
    spdlog::info("{}: recorded in {}", device.name, file.path.string());
    recorders_.push_back(
        std::make_unique<Recorder>(file, *device.pipeline.kinematics, owner_->newest(i),
                                   comparison(*scene_.record, device), realtime_.facts.sched_fifo));
    telemetry_->add(i, recorders_.back().get());
  }
}

void App::stop() {
  if (owner_) owner_->begin_closing();
  if (loop_) loop_->finish(kLongestRelease);
  for (const auto& unit : units_) {
    unit->device().close();
    log_link(unit->name(), unit->device().link_counts());
  }
  if (telemetry_) telemetry_->stop();
  if (owner_) owner_->loop_ended();
  if (front_) front_->stop();
  front_.reset();
  tick_metrics_.reset();
  event_log_.reset();
  owner_.reset();
  telemetry_.reset();
  recorders_.clear();
  loop_.reset();
  units_.clear();
}

std::vector<std::string> App::addresses() const {
  return front_ ? front_->addresses() : std::vector<std::string>{};
}

LoopFacts App::loop_facts() const {
  LoopFacts facts = loop_->statistics();
  facts.paced_by = scene_.loop.paced_by;
  for (const auto& unit : units_) facts.records_dropped += unit->records.dropped();
  return facts;
}

ServerFacts App::facts() const {
  return {version(), scene_.name, realtime_.facts, loop_facts(), steady_now() - started_};
}

}  // namespace haptic::server
