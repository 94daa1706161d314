#pragma once
/// Whether the device that shall pace the loop can: known when it is open.

#include "hw/device.hpp"
#include "server/scene/scene.hpp"

namespace haptic::server {

/// Throws DeviceError: it tells of no samples, or takes them at another period than the loop's.
void check_pacing(const LoopScene& loop, hw::Device& device);

}  // namespace haptic::server
