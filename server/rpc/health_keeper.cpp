#include "server/rpc/health_keeper.hpp"

#include <utility>

#include "server/base/steady_now.hpp"

namespace haptic::server {
namespace {

bool serving(const core::TickRecord& record, core::TimePoint now) {
  for (const core::Fault fault : {core::Fault::kDeviceSilent, core::Fault::kDeviceLost,
                                  core::Fault::kLoopLate, core::Fault::kLateBucketFull}) {
    if (record.faults().has(fault)) return false;
  }
  return record.life.state != core::DeviceState::kInit &&
         record.life.state != core::DeviceState::kClosing &&
         now - record.input.now < HealthKeeper::kSilence;
}

}  // namespace

HealthKeeper::HealthKeeper(grpc::HealthCheckServiceInterface& health,
                           std::vector<DeviceSessions*> devices)
    : health_(health), devices_(std::move(devices)) {
  look();
  looks_ = std::make_unique<Every>(kEvery, [this] { look(); });
}

HealthKeeper::~HealthKeeper() {
  looks_.reset();
  health_.SetServingStatus(false);
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
