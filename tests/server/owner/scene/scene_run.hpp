#pragma once
/// A device of a scene in virtual time, under a client that holds a proxy: what hapticd does with
/// it, without threads and sockets.

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <utility>

#include "haptic/core/tick/pipeline.hpp"
#include "hw/device_config.hpp"
#include "server/owner/scene/scene.hpp"
#include "tests/support/allocation_guard.hpp"

namespace haptic::test {

/// Where the device comes to rest, without force, in 3 s.
inline core::VecQ rest_of(const server::DeviceScene& scene) {
  const auto device = scene.source->open(scene.pipeline.kinematics, {});
  core::DeviceReading reading;
  for (int ms = 0; ms <= 3000; ++ms) {
    device->read(core::TimePoint(std::chrono::milliseconds(ms)), reading);
  }
  return reading.sample.q;
}

class SceneRun {
 public:
  explicit SceneRun(const server::DeviceScene& scene) : SceneRun(scene, *scene.source) {}
  /// `source`: what moves instead of the scene's own source.
  SceneRun(const server::DeviceScene& scene, const hw::DeviceConfig& source)
      : device_(source.open(scene.pipeline.kinematics, {})),
        pipeline_(server::pipeline_config(scene, device_->info().limits)),
        kinematics_(*scene.pipeline.kinematics) {
    input_.settings = scene.pipeline.scene;
    input_.command.tenure = 1;
    input_.command.lease_held = true;
    proxy_.tenure = 1;
    command_.tau_a = core::VecA::Zero(kinematics_.layout().n_a());
    device_->read(input_.now, input_.device);
    hold(input_.device.sample.q);
  }

  /// The client touches nothing from now on.
  void free() { mode_ = core::ProxyMode::kFree; }
  /// The proxy from now on: where the device would be at `q`.
  void hold(const core::VecQ& q) {
    mode_ = core::ProxyMode::kHeld;
    core::MatXQ J;
    ASSERT_EQ(kinematics_.evaluate(q, proxy_.x, J), core::MapStatus::kOk);
  }
  /// The proxy from now on: `x`, reached by the device or not.
  void hold_at(const core::VecX& x) { proxy_.x = x; }

  /// One tick, one frame of the client every ten, the first one free. Nothing in it may allocate.
  const core::TickRecord& tick() {
    const AllocationGuard guard;
    input_.now += std::chrono::milliseconds(1);
    if (++ticks_ % 10 == 1) publish();
    device_->read(input_.now, input_.device);
    if (const auto& tracker = pipeline_.config().tracker) track(tracker->first_dof);
    record_ = pipeline_.tick(input_, proxy_);
    command_.arm = record_.life.arm;
    command_.tau_a = record_.effort.tau_a;
    device_->write(input_.now, command_);
    EXPECT_EQ(guard.allocations() + guard.releases(), 0u);
    return record_;
  }
  const core::TickRecord& run(int ticks) {
    for (int i = 0; i < ticks; ++i) tick();
    return record_;
  }
  /// To ENGAGED with g = 1.
  void engage() {
    run(300);
    ++input_.command.engage_id;
    run(250);
    ASSERT_EQ(record_.life.engage.verdict, core::EngageVerdict::kAccepted);
    ASSERT_EQ(record_.life.state, core::LifecycleState::kEngaged);
    ASSERT_EQ(record_.life.gain, 1.0);
  }

  [[nodiscard]] const core::TickRecord& record() const { return record_; }

 private:
  void publish() {
    if (proxy_.gapless_samples == 0) proxy_.gapless_since = input_.now;
    proxy_.mode = ++proxy_.seq == 1 ? core::ProxyMode::kFree : mode_;
    ++proxy_.gapless_samples;
    proxy_.born = input_.now;
  }

  /// The tracker of the palm says what the device says.
  void track(int first_dof) {
    core::TrackerSnapshot& tracker = input_.tracker;
    ++tracker.seq;
    tracker.born = input_.now;
    for (std::size_t i = 0; i < core::kPalmDofs; ++i) {
      tracker.pose[i] = input_.device.sample.q[first_dof + static_cast<int>(i)];
    }
  }

  std::unique_ptr<hw::Device> device_;
  core::Pipeline pipeline_;
  const core::Kinematics& kinematics_;
  core::TickInput input_{.now = core::TimePoint(std::chrono::seconds(100))};
  core::ProxySnapshot proxy_{};
  core::ProxyMode mode_{core::ProxyMode::kHeld};  ///< of all samples but the first
  core::TickRecord record_{};
  hw::Command command_{};
  int ticks_{0};
};

}  // namespace haptic::test
