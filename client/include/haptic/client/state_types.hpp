#pragma once
/// The types in a DeviceState, and names for people. The numbers are those of
/// proto/haptic/v1/session.proto.

#include <cstdint>
#include <string>
#include <vector>

namespace haptic::client {

/// How a proxy acts between two samples.
enum class Mode : std::uint8_t {
  kNone = 0,    ///< only in states: no proxy is in use
  kHeld = 1,    ///< it stays where it is
  kFree = 2,    ///< nothing is in the way: no force
  kPlanes = 3,  ///< the server keeps the probe out of planes
};
/// The delay that lowers the stiffness (core/METHOD.md#stiffness-in-effect).
enum class Derating : std::uint8_t { kNone = 0, kDevice = 1, kHeld = 2, kPlanes = 3 };
/// The age of the sample in use: force is full (FRESH, HOLD), fades (FADE) or is gone (LOST).
enum class Staleness : std::uint8_t { kUnknown = 0, kFresh = 1, kHold = 2, kFade = 3, kLost = 4 };
/// The way by which a sample or a state came.
enum class Carrier : std::uint8_t { kUnknown = 0, kGrpc = 1, kUdp = 2 };
/// The state of a device. Force is rendered from kEngaging to kReleasing only.
enum class Lifecycle : std::uint8_t {
  kUnknown = 0,
  kInit = 1,       ///< the device opens
  kIdle = 2,       ///< no controller has the device
  kArmed = 3,      ///< a controller has it and may ask for force; damping only
  kEngaging = 4,   ///< force rises
  kEngaged = 5,    ///< force is fully on
  kReleasing = 6,  ///< force fades out
  kFault = 7,      ///< zero force until the fault is cleared
  kClosing = 8,    ///< the server ends
};
[[nodiscard]] const char* name(Lifecycle state) noexcept;      ///< "ENGAGED"
[[nodiscard]] const char* name(Staleness staleness) noexcept;  ///< "FRESH"
[[nodiscard]] const char* name(Carrier carrier) noexcept;      ///< "GRPC"
/// The names of the bits of DeviceState::faults and DeviceState::limiters, for example
/// {"LOOP_LATE", "EMERGENCY_STOP"}. A bit that this library does not know is named by its number.
[[nodiscard]] std::vector<std::string> fault_names(std::uint32_t faults);
[[nodiscard]] std::vector<std::string> limiter_names(std::uint32_t limiters);

}  // namespace haptic::client
