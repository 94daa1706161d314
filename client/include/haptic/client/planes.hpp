#pragma once
/// Planes for a simulation that has none: one per constrained block, from the proxy and the haptic
/// probe it was computed from. The server then moves the proxy along them at 1 kHz, so that nothing
/// drags while the network is slow, and only a contact's first sample comes late.

#include <cstddef>
#include <vector>

#include "haptic/client/types.hpp"

namespace haptic::client {

/// Coordinates that are constrained together: a fingertip, a joint, a tool. `first` and how many.
struct Block {
  std::size_t first{0};
  std::size_t count{0};
};

/// The plane of a block has the normal x_probe - x (kind "angle" the short way round, a "quaternion"
/// with the sign nearer to x)
/// and holds x: x is the point nearest to x_probe that it allows, the proxy as it was computed (in a
/// scene with a metric that weighs a block's coordinates differently, a point of the same plane). A
/// block whose proxy is its probe, to `least` (m or rad), is not constrained and has no plane. Of more
/// than 6 the ones with the largest distance stay. `blocks` empty: all coordinates are one.
///
/// Sizes: x and x_probe one value per coordinate; else, and where a block lies outside, no plane.
[[nodiscard]] std::vector<Plane> derive_planes(const std::vector<VirtualCoordinate>& coordinates,
                                               const std::vector<double>& x,
                                               const std::vector<double>& x_probe,
                                               const std::vector<Block>& blocks = {},
                                               double least = 1e-9);

}  // namespace haptic::client
