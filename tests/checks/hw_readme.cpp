/// The device of hw/README.md as it stands there, for the tests NewDevice.

#include <memory>
#include <string>

#include "haptic/core/error.hpp"
#include "hw/bookkeeping.hpp"
#include "hw/device_config.hpp"
#include "hw/device_limits.hpp"

namespace haptic::hw::readme {

#include "hw_readme_1.inc"

std::unique_ptr<const DeviceConfig> spring() {
  return std::make_unique<SpringConfig>();
}

}  // namespace haptic::hw::readme
