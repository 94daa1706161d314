#pragma once
/// Between the structs of haptic_types.h and those of the C++ client.

#include "haptic/client/client.hpp"
#include "haptic/haptic_types.h"

namespace haptic::c {

[[nodiscard]] haptic_device to_device(const client::DeviceInfo& device);
[[nodiscard]] haptic_state to_state(const client::DeviceState& state);
[[nodiscard]] haptic_settings to_settings(const client::AppliedSettings& settings);
// These throw kInvalidArgument.
[[nodiscard]] client::SessionOptions to_options(const haptic_session_options& options);
[[nodiscard]] client::Settings to_settings(const haptic_settings& settings);
/// `coordinates`: how many the device has.
[[nodiscard]] client::Plane to_plane(const haptic_plane& plane, std::size_t coordinates);
[[nodiscard]] std::vector<double> to_position(const double* x, std::size_t count,
                                              std::size_t coordinates);

}  // namespace haptic::c
