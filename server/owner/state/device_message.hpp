#pragma once
/// The part of ListDevices' answer that does not change while it is open.

#include <string>

#include "haptic/v1/haptic_service.pb.h"
#include "hw/device.hpp"

namespace haptic::server {

[[nodiscard]] v1::Device describe(const std::string& name, const hw::DeviceInfo& info,
                                  const core::PipelineConfig& config);

}  // namespace haptic::server
