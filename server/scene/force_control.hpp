#pragma once
/// Who closes the loop on the measured force of a device, as plain values.

#include <cstdint>

#include "haptic/core/control/force_control.hpp"
#include "hw/device.hpp"

namespace haptic::server {

/// What the scene takes for granted of the device; a device without it is refused at its opening.
enum class ForceControlPlace : std::uint8_t {
  kAny = 0,         ///< the scene does not say
  kBoard = 1,       ///< the board closes the loop itself
  kServer = 2,      ///< measures force, takes forces, does not close the loop itself
  kAdmittance = 3,  ///< measures force, takes positions
};

struct ForceControlScene {
  ForceControlPlace place{ForceControlPlace::kAny};
  core::ForceControlSettings settings{};  ///< of kServer and kAdmittance
};

/// Throws DeviceError where the opened device cannot do what the scene takes for granted.
void check_force_control(ForceControlPlace place, const hw::DeviceInfo& device);

}  // namespace haptic::server
