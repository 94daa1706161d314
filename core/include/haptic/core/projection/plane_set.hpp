#pragma once
/// Planes of a local model (core/METHOD.md#local-models): what the proxy may not pass between two
/// samples.

#include <cstdint>
#include <tuple>

#include "haptic/core/types.hpp"

namespace haptic::core {

/// Planes in one sample. A finger needs one or two, a hand one per finger and one for the palm.
inline constexpr int kMaxPlanes = 6;

/// n_i^T x <= b_i, linearised at the sample's own x. A normal is a covector: unit of b_i per unit
/// of each coordinate; its length is free (n and b may be scaled together).
struct PlaneSet {
  using Normals = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxX, kMaxPlanes>;
  using Offsets = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxPlanes, 1>;

  Normals normals{};  ///< n_x by number of planes, a normal per column
  Offsets offsets{};  ///< b, one per plane

  [[nodiscard]] int size() const noexcept { return static_cast<int>(offsets.size()); }

  [[nodiscard]] auto members() const noexcept { return std::tie(normals, offsets); }
};

}  // namespace haptic::core
