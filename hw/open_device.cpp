#include "hw/open_device.hpp"

#include <utility>

#include "haptic/core/error.hpp"

namespace haptic::hw {

std::unique_ptr<Device> open_device(const DeviceConfig& config,
                                    std::shared_ptr<const core::Kinematics> kinematics,
                                    core::Duration longest_lateness) {
  if (!kinematics) throw core::DeviceError("a device cannot be opened without its kinematics");
  return config.open(std::move(kinematics), longest_lateness);
}

}  // namespace haptic::hw
