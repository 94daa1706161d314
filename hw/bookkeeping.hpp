#pragma once
/// State that every device without a link needs: whether it is armed or closed, and the numbers of
/// its samples. The simulated devices and the replay have it as a member. See hw/device.hpp for the
/// states.

#include <cstdint>

#include "haptic/core/tick/tick_input.hpp"
#include "haptic/core/time.hpp"
#include "hw/device.hpp"

namespace haptic::hw {

class Bookkeeping {
 public:
  /// First thing in read(): sets all but the sample. True if time has passed since the last call
  /// that returned true; then a new sample is due. After close() the device is LOST.
  [[nodiscard]] bool begin_read(core::TimePoint now, core::DeviceReading& reading) noexcept {
    armed_ = wanted_;  // there is no handshake: armed one tick after it was wanted
    reading.armed = armed_;
    reading.health = closed_ ? core::DeviceHealth::kLost : core::DeviceHealth::kOk;
    reading.fresh = false;
    if (closed_ || now <= last_read_) return false;
    last_read_ = now;
    return true;
  }
  /// In read(): `q` is the new sample, measured `now`.
  void deliver(core::TimePoint now, const core::VecQ& q, core::DeviceReading& reading) noexcept {
    reading.fresh = true;
    reading.sample.seq = ++seq_;
    reading.sample.time = now;
    reading.sample.q = q;
    reading.sample.tau_measured.resize(0);
  }
  /// First thing in write(): true if the device is armed, so that command.tau_a counts. False for
  /// the command that asks for the arming, because the device is still ARMING.
  [[nodiscard]] bool follows(const Command& command) noexcept {
    wanted_ = command.arm && !closed_;
    armed_ = armed_ && wanted_;
    return armed_;
  }
  void close() noexcept {
    closed_ = true;
    wanted_ = armed_ = false;
  }

 private:
  bool wanted_{false};
  bool armed_{false};
  bool closed_{false};
  core::TimePoint last_read_{core::TimePoint::min()};
  std::uint64_t seq_{0};
};

}  // namespace haptic::hw
