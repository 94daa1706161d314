#pragma once
/// What goes wrong, and when: part of an emulator's configuration, so that a run can be repeated.

#include <cstdint>
#include <string>
#include <vector>

namespace haptic::hw::emulator {

enum class FaultKind : std::uint8_t {
  kStall,     ///< the motor gives nothing
  kBrownOut,  ///< the board loses its supply and restarts after it
  kUnplug,    ///< the port is gone, the board runs on
  kStuck,     ///< the potentiometer of l_x repeats its last reading
  kDrift,     ///< the potentiometer of l_x wanders by `amount` m/s, for good
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
[[nodiscard]] std::string name(FaultKind kind);

/// `count` faults of kinds, times within `seconds` and lengths of 0.2 to 2 s drawn from the seed.
[[nodiscard]] std::vector<FaultSpec> draw_faults(std::uint64_t seed, int count, double seconds);

}  // namespace haptic::hw::emulator
