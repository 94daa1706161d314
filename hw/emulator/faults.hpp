#pragma once
/// Faults of an emulated board and when they happen.

#include <cstdint>
#include <string>

namespace haptic::hw::emulator {

enum class FaultKind : std::uint8_t {
  kStall,     ///< the motor gives no force
  kBrownOut,  ///< the board loses its supply and restarts after it
  kUnplug,    ///< the port vanishes, the board runs on
  kStuck,     ///< the potentiometer of l_x repeats its last reading
  kDrift,     ///< the potentiometer of l_x drifts by `amount` m/s and keeps the error
  kHang,      ///< the firmware neither samples nor listens; its hardware watchdog cuts the drive
};

struct FaultSpec {
  FaultKind kind{};
  double at{0.0};      ///< s since the start
  double length{1e9};  ///< s
  double amount{0.0};
  [[nodiscard]] bool active(double t) const noexcept { return t >= at && t < at + length; }
};

/// "kind@START[+LENGTH][=AMOUNT]", as in "unplug@10+2" or "drift@5=0.0001"; kinds stall, brown-out,
/// unplug, stuck, drift, hang. Throws DeviceError saying what is wrong and what is allowed.
[[nodiscard]] FaultSpec parse_fault(const std::string& text);

}  // namespace haptic::hw::emulator
