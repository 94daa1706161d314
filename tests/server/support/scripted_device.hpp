#pragma once
/// A device with readings set by the test; it keeps the commands it was given. Two DoFs, the first
/// actuated.

#include <atomic>

#include "hw/device.hpp"

namespace haptic::test {

class ScriptedDevice final : public hw::Device {
 public:
  /// `max_effort`: N.
  explicit ScriptedDevice(double max_effort = 20.0) {
    info_.kind = "scripted";
    info_.model = "test";
    info_.dofs = dofs();
    info_.limits.q_lower = core::VecQ::Constant(2, -1.0);
    info_.limits.q_upper = core::VecQ::Constant(2, 1.0);
    info_.limits.max_effort = core::VecA::Constant(1, max_effort);
  }

  static std::vector<core::DofSpec> dofs() {
    return {{"slide", core::Unit::kMetre, true, -0.5, 0.5},
            {"swing", core::Unit::kMetre, false, -0.5, 0.5}};
  }

  [[nodiscard]] const hw::DeviceInfo& info() const noexcept override { return info_; }

  void read(core::TimePoint now, core::DeviceReading& reading) noexcept override {
    reading.fresh = !silent;
    reading.armed = armed_;
    reading.health = lost ? core::DeviceHealth::kLost : core::DeviceHealth::kOk;
    if (silent) return;
    ++reading.sample.seq;
    reading.sample.time = now;
    reading.sample.q = q;
    reading.sample.tau_measured.resize(0);
  }

  void write(core::TimePoint /*now*/, const hw::Command& command) noexcept override {
    armed_ = command.arm;
    force = command.tau_a.size() > 0 ? command.tau_a[0] : 0.0;
  }

  void close() noexcept override {}

  core::VecQ q = core::VecQ::Zero(2);  ///< of every sample; set before the first
  std::atomic<bool> silent{false};     ///< gives no new sample
  std::atomic<bool> lost{false};       ///< reports itself gone
  std::atomic<double> force{0.0};      ///< N, of the last command

 private:
  hw::DeviceInfo info_{};
  bool armed_{false};
};

}  // namespace haptic::test
