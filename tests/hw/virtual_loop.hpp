#pragma once
/// A loop in virtual time around a device: read, then write, once a period.

#include <chrono>

#include "hw/device.hpp"

namespace haptic::test {

class VirtualLoop {
 public:
  explicit VirtualLoop(hw::Device& device) : device_(device) {
    command_.tau_a = core::VecA::Zero(device.info().limits.max_effort.size());
  }

  const core::DeviceReading& tick() {
    device_.read(now_, reading_);
    device_.write(now_, command_);
    now_ += period_;
    return reading_;
  }
  void run(core::Duration length) {
    for (const core::TimePoint end = now_ + length; now_ < end;) tick();
  }
  /// Arms the device and lets it render `tau_a` on its first actuated DoF, N, from the next tick
  /// on.
  void push(double tau_a) {
    command_.arm = true;
    command_.tau_a[0] = tau_a;
  }
  void disarm() { command_.arm = false; }
  void set_period(core::Duration period) { period_ = period; }
  [[nodiscard]] const core::DeviceReading& reading() const { return reading_; }
  [[nodiscard]] core::TimePoint now() const { return now_; }

 private:
  hw::Device& device_;
  core::Duration period_{std::chrono::milliseconds(1)};
  core::TimePoint now_{std::chrono::seconds(1000)};
  core::DeviceReading reading_{};
  hw::Command command_{};
};

}  // namespace haptic::test
