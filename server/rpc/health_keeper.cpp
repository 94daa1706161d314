#include "server/rpc/health_keeper.hpp"

#include <utility>

#include "server/rpc/steady_now.hpp"

namespace haptic::server {
namespace {

bool serving(const core::TickRecord& record, core::TimePoint now) {
  for (const core::Fault fault : {core::Fault::kDeviceSilent, core::Fault::kDeviceLost,
                                  core::Fault::kLoopLate, core::Fault::kLateBucketFull}) {
    if (record.faults.has(fault)) return false;
  }
  return record.state != core::DeviceState::kInit && record.state != core::DeviceState::kClosing &&
         now - record.input.now < HealthKeeper::kSilence;
}

}  // namespace

HealthKeeper::HealthKeeper(grpc::HealthCheckServiceInterface& health,
                           std::vector<DeviceSessions*> devices)
    : health_(health), devices_(std::move(devices)) {
  look();
  const std::lock_guard lock(mutex_);
  set_alarm();
}

HealthKeeper::~HealthKeeper() {
  std::unique_lock lock(mutex_);
  stopping_ = true;
  if (alarm_) alarm_->Cancel();
  idle_.wait(lock, [&] { return !waiting_; });
  lock.unlock();
  health_.SetServingStatus(false);
}

void HealthKeeper::set_alarm() {
  waiting_ = true;
  alarm_ = std::make_unique<grpc::Alarm>();
  alarm_->Set(std::chrono::system_clock::now() + kEvery, [this](bool rang) {
    if (rang) look();
    const std::lock_guard lock(mutex_);
    if (stopping_ || !rang) {
      waiting_ = false;
      idle_.notify_all();
    } else {
      set_alarm();
    }
  });
}

void HealthKeeper::look() {
  const core::TimePoint now = steady_now();
  bool all = true;
  for (const DeviceSessions* device : devices_) {
    const bool good = serving(device->newest(), now);
    all = all && good;
    health_.SetServingStatus(device->name(), good);
  }
  health_.SetServingStatus("", all);
}

}  // namespace haptic::server
