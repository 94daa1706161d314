#pragma once
/// Faults and limiters. Faults latch and zero the command until cleared; limiters act for one tick
/// and are reported. The numbers are stable: they travel in DeviceState and stand in recordings.

#include <cstdint>
#include <string_view>

namespace haptic::core {

/// 1..31 latching faults. Bit n of a FaultSet is the fault of number n.
enum class Fault : std::uint8_t {
  kDeviceSilent = 1,      ///< no sample for longer than the device's max_silence
  kDeviceLost = 2,        ///< the device reports its link or itself gone
  kSampleNotFinite = 3,   ///< NaN or infinity in q
  kSampleOutOfRange = 4,  ///< q outside the DoF's range and its margin
  kLoopLate = 5,          ///< one wake-up later than loop_late_fault (also a suspend)
  kLateBucketFull = 6,    ///< too many late ticks: the late bucket is full
  kEmergencyStop = 7,     ///< asked for by a person or a program
  kForceOverLimit = 8,    ///< the device measured more force than it is allowed to give
  kOutputNotFinite = 9,   ///< the computed command was NaN or infinite: our own defect
  // The load cell of a force loop cannot be believed (core/METHOD.md#a-load-cell-that-lies):
  kForceOutOfRange = 10,  ///< it reads more than it can
  kForceTooFast = 11,     ///< its reading grew faster than a force can
  kForceStuck = 12,       ///< the very same reading, while the drive moved on
  kForceDisagrees = 13,   ///< more than friction between the reading and what the drive gives
};

/// 0..31 limiters, one tick each. Bit n of a LimiterSet is the limiter of number n.
enum class Limiter : std::uint8_t {
  kSaturation = 0,      ///< |tau_a| held at the force limit
  kSlew = 1,            ///< d tau_a/dt held at the slew limit
  kEnvelope = 2,        ///< elastic force held under g tau_max
  kDirectionGuard = 3,  ///< elastic force withheld: it pointed away from the proxy
                        ///< (core/METHOD.md#forces-at-the-finger)
  kRangeClamp = 4,      ///< q* held at its box or slider limits
  kEnergyTank = 5,      ///< a change of the spring held back: the tank cannot pay it
                        ///< (core/METHOD.md#energy-tank)
  kPassivity = 6,  ///< the passivity controller adds damping (core/METHOD.md#passivity-observer)
  kInfeasiblePlanes = 7,  ///< the planes contradict each other: least violation
                          ///< (core/METHOD.md#local-models)
  // 8 was the monotone envelope's.
  kPower = 9,         ///< the actuator would give out more power than it is rated for
  kRate = 10,         ///< no push beyond the actuator's rated rate
  kTemperature = 11,  ///< force held at what the winding's estimated temperature allows
  kDriveLimit = 12,   ///< force loop or admittance held at its output, rate or travel limit
  kContacts = 13,     ///< force held back: one contact's push would push another contact in
                      ///< (core/METHOD.md#rendering-per-contact)
  kSingular = 14,     ///< J^+ is damped near a singular pose
                      ///< (core/METHOD.md#damping-near-singular-poses)
  kBranch = 15,  ///< q* held on its branch, or moved to another one in steps, where two poses are
                 ///< about equally near (core/METHOD.md#projection-algorithm)
  kNeverFree = 16,      ///< no force starts: the proxy is held, and no sample of its lease was free
  kDerated = 17,        ///< stiffness below the settings', for the loop's delay
                        ///< (core/METHOD.md#stiffness-in-effect)
  kOutsideWindow = 18,  ///< no force starts: it would begin with more than the engage window
  kTooFast = 19,        ///< samples are not fresh: more than twice as many come as were announced
  kNotFelt = 20,        ///< the proxy's displacement stretches no actuated spring: no motor moves
                        ///< the tool that way, or the prior leaves it to sensed DoFs
};

template <typename E>
class BitSet32 {
 public:
  constexpr BitSet32() = default;
  explicit constexpr BitSet32(std::uint32_t bits) : bits_(bits) {}
  constexpr void set(E e) noexcept { bits_ |= mask(e); }
  constexpr void clear(BitSet32 which) noexcept { bits_ &= ~which.bits_; }
  [[nodiscard]] constexpr bool has(E e) const noexcept { return (bits_ & mask(e)) != 0; }
  [[nodiscard]] constexpr bool any() const noexcept { return bits_ != 0; }
  [[nodiscard]] constexpr std::uint32_t bits() const noexcept { return bits_; }
  friend constexpr bool operator==(BitSet32, BitSet32) = default;
  friend constexpr BitSet32 operator|(BitSet32 a, BitSet32 b) {
    return BitSet32(a.bits_ | b.bits_);
  }

 private:
  static constexpr std::uint32_t mask(E e) noexcept {
    return std::uint32_t{1} << static_cast<unsigned>(e);
  }
  std::uint32_t bits_{0};
};

using FaultSet = BitSet32<Fault>;
using LimiterSet = BitSet32<Limiter>;

/// Stable reason strings, as in events and ErrorInfo: "DEVICE_SILENT", "SATURATION", ...
[[nodiscard]] std::string_view reason(Fault fault) noexcept;
[[nodiscard]] std::string_view reason(Limiter limiter) noexcept;

}  // namespace haptic::core
