#pragma once
/// One device with its pipeline and its mailboxes: here the real-time side and the rest of the
/// server meet. Rows 1 to 12 of core/README.md#one-tick are its tick().

#include <atomic>
#include <memory>
#include <string>

#include "haptic/core/tick/mailbox.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "haptic/core/tick/ring.hpp"
#include "hw/device.hpp"

namespace haptic::server {

class DeviceUnit {
 public:
  /// Records kept for a slow telemetry drain: half a second at 1 kHz.
  static constexpr std::size_t kRingCapacity = 512;

  DeviceUnit(std::string name, std::unique_ptr<hw::Device> device, core::PipelineConfig config);
  DeviceUnit(const DeviceUnit&) = delete;
  DeviceUnit& operator=(const DeviceUnit&) = delete;

  /// Real-time thread: read, take mailboxes, Pipeline::tick, write, record. Never allocates, locks,
  /// logs, throws, blocks.
  void tick(core::TimePoint now, core::Duration period, const core::LoopReport& loop) noexcept;

  /// Before the first tick: runs a second pipeline through its ways of working, so that code and
  /// tables are in memory when the first deadline comes. Leaves no trace in the unit. Allocates.
  void rehearse() const;

  /// The device's state after the newest tick. Any thread.
  [[nodiscard]] core::LifecycleState state() const noexcept {
    return state_.load(std::memory_order_acquire);
  }

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] hw::Device& device() noexcept { return *device_; }
  [[nodiscard]] const hw::Device& device() const noexcept { return *device_; }
  [[nodiscard]] const core::PipelineConfig& config() const noexcept { return pipeline_.config(); }

  /// Written by the ingress, under the owner's lock.
  core::Mailbox<core::ProxySnapshot> proxies;
  /// Written by the device's tracker, under the owner's lock.
  core::Mailbox<core::TrackerSnapshot> poses;
  /// Written by the device's sessions, under the owner's lock.
  core::Mailbox<core::CommandSnapshot> commands;
  core::Mailbox<core::RenderSettings> settings;
  /// Records as the tick left them; read by the telemetry drain, which completes them.
  core::Ring<core::TickRecord> records;

 private:
  std::string name_;
  std::unique_ptr<hw::Device> device_;
  core::Pipeline pipeline_;
  core::TickInput input_{};
  hw::Command command_{};
  std::atomic<core::LifecycleState> state_{core::LifecycleState::kInit};
};

}  // namespace haptic::server
