#include "server/scene/force_control.hpp"

#include <string>

#include "haptic/core/error.hpp"

namespace haptic::server {

void check_force_control(ForceControlPlace place, const hw::DeviceInfo& device) {
  const auto require = [](bool holds, const std::string& what) {
    if (!holds) throw core::DeviceError("force_control: " + what);
  };
  switch (place) {
    case ForceControlPlace::kAny:
      return;
    case ForceControlPlace::kBoard:
      require(device.closes_force_loop,
              "board {}: this device does not close the loop on its force; must be server or "
              "admittance, where it measures force");
      return;
    case ForceControlPlace::kServer:
      require(device.measures_force, "server {}: this device measures no force");
      require(
          !device.closes_force_loop,
          "server {}: this device closes the loop itself, and two loops in a row fight; must be "
          "board {}");
      return;
    case ForceControlPlace::kAdmittance:
      require(device.measures_force, "admittance {}: this device measures no force");
      require(device.takes_positions, "admittance {}: this device does not take positions");
      return;
  }
}

}  // namespace haptic::server
