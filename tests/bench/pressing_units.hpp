#pragma once
/// Units of one scene's device that all press: under a lease, engaged, with a new proxy in every
/// tick. The caller's thread ticks them in order, on virtual time.

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "server/owner/loop/device_unit.hpp"
#include "server/owner/scene/scene.hpp"

namespace haptic::bench {

class PressingUnits {
 public:
  /// Opens `count` of them and ticks until force is on. Throws if one gives none: ticks
  /// without force would be too cheap.
  PressingUnits(const server::DeviceScene& device, int count) {
    for (int i = 0; i < count; ++i) {
      auto opened = device.source->open(device.pipeline.kinematics, {});
      const core::PipelineConfig config = server::pipeline_config(device, opened->info().limits);
      units_.push_back(std::make_unique<Unit>(device.name, std::move(opened), config));
    }
    core::CommandSnapshot command;
    command.tenure = 1;
    command.lease_held = true;
    publish(command);
    tick(kHandComesToRest);
    proxy_.mode = core::ProxyMode::kFree;
    proxy_.tenure = 1;
    proxy_.gapless_since = now_;
    tick(1);
    proxy_.mode = core::ProxyMode::kHeld;
    proxy_.x = x_probe_;
    tick(kStream);
    command.engage_id = 1;
    publish(command);
    tick(kRamp);
    proxy_.x[0] += kPush;
    tick(kRamp);
    check();
  }

  /// Ticks every unit so many times.
  void tick(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      now_ += kPeriod;
      proxy_.born = now_;
      ++proxy_.seq;
      ++proxy_.gapless_samples;
      for (const auto& unit : units_) {
        server::DeviceUnit& device = unit->device;
        if (proxy_.mode != core::ProxyMode::kNone) device.proxies.publish(proxy_);
        device.tick(now_, kPeriod, {});
        const core::TickRecord& record = *device.records.front();
        unit->presses = record.life.state == core::LifecycleState::kEngaged &&
                        record.effort.tau_elastic.cwiseAbs().maxCoeff() > 0.0;
        x_probe_ = record.anchor.x_probe;
        device.records.pop();
      }
    }
  }

  /// Throws unless all of them press.
  void check() const {
    const auto presses = [](const auto& unit) { return unit->presses; };
    if (!std::all_of(units_.begin(), units_.end(), presses)) {
      throw std::runtime_error("a unit whose ticks are measured does not press");
    }
  }

 private:
  struct Unit {
    Unit(const std::string& name, std::unique_ptr<hw::Device> opened,
         const core::PipelineConfig& config)
        : device(name, std::move(opened), config) {}
    server::DeviceUnit device;
    bool presses{false};  ///< in its last tick
  };

  static constexpr core::Duration kPeriod = std::chrono::milliseconds(1);
  static constexpr int kHandComesToRest = 1000;  // its motion takes 0.8 s
  static constexpr int kStream = 250, kRamp = 250;
  static constexpr double kPush = 0.02;  // rad or m, of the first coordinate

  void publish(const core::CommandSnapshot& command) {
    for (const auto& unit : units_) unit->device.commands.publish(command);
  }

  std::vector<std::unique_ptr<Unit>> units_{};
  core::TimePoint now_{kPeriod};
  core::ProxySnapshot proxy_{};
  core::VecX x_probe_{};
};

}  // namespace haptic::bench
