#pragma once
/// Between the structs of haptic_types.h and those of the C++ client.

#include "haptic/client/client.hpp"
#include "haptic/haptic_types.h"
#include "state_struct.hpp"

namespace haptic::c {

[[nodiscard]] haptic_settings to_settings(const client::AppliedSettings& settings);
// These throw kInvalidArgument.
[[nodiscard]] client::SessionOptions to_options(const haptic_session_options& options);
[[nodiscard]] client::Settings to_settings(const haptic_settings& settings);
/// `coordinates`: how many the device has.
[[nodiscard]] client::Plane to_plane(const haptic_plane& plane, std::size_t coordinates);
[[nodiscard]] haptic_plane to_plane(const client::Plane& plane);
[[nodiscard]] client::PointMap to_point(const haptic_point& point);
[[nodiscard]] haptic_point to_point(const client::PointMap& point);
[[nodiscard]] client::Contact to_contact(const haptic_contact& contact);
[[nodiscard]] std::vector<client::Block> to_blocks(const haptic_block* blocks, std::size_t count);
[[nodiscard]] std::vector<double> to_position(const double* x, std::size_t count,
                                              std::size_t coordinates);
[[nodiscard]] inline client::Vector3 to_vector(const double* from) {
  return {from[0], from[1], from[2]};
}

}  // namespace haptic::c
