#pragma once
/// The arming of a device without a handshake: armed one tick after it is wanted, disarmed at once.
/// DISARMED -> write(arm) -> ARMING -> next read() -> ARMED; see hw/device.hpp.

namespace haptic::hw {

class Arming {
 public:
  /// In read(): the handshake that the last write() asked for is done.
  void on_read() noexcept { armed_ = wanted_; }
  /// In write(): what the server wants from now on. A force that comes with the first request is
  /// not followed: the device is still arming.
  void on_write(bool wanted) noexcept {
    wanted_ = wanted;
    armed_ = armed_ && wanted;
  }
  void disarm() noexcept { wanted_ = armed_ = false; }
  [[nodiscard]] bool armed() const noexcept { return armed_; }

 private:
  bool wanted_{false};
  bool armed_{false};
};

}  // namespace haptic::hw
