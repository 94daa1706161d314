/// The device of hw/README.md as it stands there, compiled, and made: it forgets no method of the
/// interface.

#include <cstdint>
#include <memory>
#include <utility>

#include "hw/arming.hpp"
#include "hw/device_limits.hpp"
#include "hw/open_device.hpp"

namespace haptic::hw::readme {

#include "hw_readme_1.inc"

std::unique_ptr<Device> spring(std::shared_ptr<const core::Kinematics> kinematics) {
  return open_device(SpringConfig{}, std::move(kinematics));
}

}  // namespace haptic::hw::readme
