#pragma once
/// The part of ListDevices' answer that does not change while it is open.

#include <memory>
#include <string>
#include <vector>

#include "haptic/v1/haptic_service.pb.h"
#include "hw/device.hpp"

namespace haptic::server {

[[nodiscard]] v1::Device describe(const std::string& name, const hw::DeviceInfo& info,
                                  const core::PipelineConfig& config);

/// Several of them as bytes, and back; empty: the bytes are none.
[[nodiscard]] std::string to_bytes(const std::vector<std::shared_ptr<const v1::Device>>& devices);
[[nodiscard]] std::vector<std::shared_ptr<const v1::Device>> devices_of(const std::string& bytes);

}  // namespace haptic::server
