#pragma once
/// x (-) y, as the server takes it.

#include <vector>

#include "haptic/client/types.hpp"

namespace haptic::client {

/// Coordinate i of x_probe (-) x: an angle the short way round, a quaternion with the sign that is
/// nearer to x.
[[nodiscard]] double difference(const std::vector<VirtualCoordinate>& coordinates,
                                const std::vector<double>& x_probe, const std::vector<double>& x,
                                std::size_t i);

}  // namespace haptic::client
