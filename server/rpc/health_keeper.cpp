#include "server/rpc/health_keeper.hpp"

#include "server/base/steady_now.hpp"

namespace haptic::server {
namespace {

bool serving(const DeviceStatus& status, core::TimePoint now) {
  for (const core::Fault fault : {core::Fault::kDeviceSilent, core::Fault::kDeviceLost,
                                  core::Fault::kLoopLate, core::Fault::kLateBucketFull}) {
    if (status.faults.has(fault)) return false;
  }
  return status.state != core::LifecycleState::kInit &&
         status.state != core::LifecycleState::kClosing &&
         now - status.ticked < HealthKeeper::kSilence;
}

}  // namespace

HealthKeeper::HealthKeeper(grpc::HealthCheckServiceInterface& health, const OwnerPort& owner)
    : health_(health), owner_(owner) {
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
  for (std::size_t i = 0; i < owner_.devices().size(); ++i) {
    const bool good = serving(owner_.status(i), now);
    all = all && good;
    health_.SetServingStatus(owner_.devices()[i].name, good);
  }
  health_.SetServingStatus("", all);
}

}  // namespace haptic::server
