#pragma once
/// Planes, and those of a simulation that only knows its proxy. A plane says what the haptic probe
/// may not pass; the server keeps the probe out of it at 1 kHz. Compared with a held proxy, nothing
/// drags along the surface while the network is slow, and only the first sample of a contact comes
/// late.

#include <cstddef>
#include <vector>

#include "haptic/client/types.hpp"

namespace haptic::client {

/// Consecutive coordinates that are constrained together: a fingertip, a joint, a tool.
struct Block {
  std::size_t first{0};
  std::size_t count{0};
};

// Limits of one sample (proto/README.md).
inline constexpr std::size_t kMaxPlanes = 32;
inline constexpr std::size_t kMaxContactsOfBlock = 8;
inline constexpr std::size_t kMaxCurvatures = 320;     ///< numbers, of all contacts
inline constexpr std::size_t kMaxNumbersOfPlane = 80;  ///< of its normal and its curvature

/// The contact with this gap (>= 0: not touched) and gradient of the gap (one value per coordinate)
/// where the virtual object is at `x`, which must be the sample's position. The caller adds
/// compliance, velocity, curvature and id.
[[nodiscard]] Plane contact(const std::vector<double>& x, double gap,
                            const std::vector<double>& gradient);

/// Leaves the planes that x_probe is deepest beyond, or nearest to, in their order, and returns how
/// many it took out. From the deepest on it takes up to kMaxPlanes; a contact (a plane with
/// compliance, curvature or id) only if fewer than kMaxContactsOfBlock of those taken share a
/// coordinate with it. A curvature that has no room left becomes 0. Depth is the violation of the
/// linear gap by the length of its gradient, in units of x. `x`: where they are linearised,
/// and the probe if that is not known (empty). publish() does this by itself and counts
/// (PublishStatistics::planes_left_out). If another size does not fit, the first kMaxPlanes stay.
std::size_t keep_deepest(const std::vector<VirtualCoordinate>& coordinates,
                         const std::vector<double>& x, const std::vector<double>& x_probe,
                         std::vector<Plane>& planes);

/// One plane per block, from the proxy x and the haptic probe x_probe that x was computed from, one
/// value per coordinate each. The plane passes through x and its normal is x_probe - x, so that x
/// is the point nearest to x_probe that it allows. Coordinates of kind "angle" differ the short way
/// round, a "quaternion" has the sign that is nearer to x.
///
/// The planes are rigid; ContactEstimator in estimator.hpp makes them give way as the object does.
/// A block whose proxy is within `least` (m or rad) of its probe is not constrained and gets no
/// plane. `blocks` empty: all coordinates are one block. If a size does not fit, or a block ends
/// beyond the last coordinate, it has no plane.
[[nodiscard]] std::vector<Plane> derive_planes(const std::vector<VirtualCoordinate>& coordinates,
                                               const std::vector<double>& x,
                                               const std::vector<double>& x_probe,
                                               const std::vector<Block>& blocks = {},
                                               double least = 1e-9);

}  // namespace haptic::client
