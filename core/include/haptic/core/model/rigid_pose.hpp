#pragma once
/// Poses of rigid bodies in scenes and maps: position in m, orientation as a unit
/// quaternion (x, y, z, w). A device's orientation stands in q as a rotation vector (three DoFs, so
/// that q* = q + dq and J keep their meaning); an output's orientation stands in x as the
/// quaternion itself (core/METHOD.md#metric-and-limits).

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "haptic/core/types.hpp"

namespace haptic::core {

struct Point3 {
  double x{0.0}, y{0.0}, z{0.0};
};

struct UnitQuaternion {
  double x{0.0}, y{0.0}, z{0.0}, w{1.0};
};

/// A frame in another: p_outer = position + orientation p_inner orientation^-1.
struct Pose3 {
  Point3 position{};             ///< m
  UnitQuaternion orientation{};  ///< normalised when it is read; must not be zero
};

/// The coordinates that an output adds to X.
enum class OutputKind : std::uint8_t {
  kPoint,  ///< 3 coordinates: x, y, z [m]
  kFrame,  ///< 7 coordinates: x, y, z [m], quaternion x, y, z, w
};

/// The rotation vector (axis times angle, rad) of a unit quaternion, angle in [0, pi]: how a
/// tracker's reading enters q. q and -q give the same; zero or not finite gives zero.
[[nodiscard]] Eigen::Vector3d rotation_vector(const UnitQuaternion& orientation) noexcept;

/// The rotation vector nearest to `near` that means the same rotation as phi.
[[nodiscard]] Eigen::Vector3d nearest_rotation_vector(const Eigen::Vector3d& phi,
                                                      const Eigen::Vector3d& near) noexcept;

/// A tracked body below the device: six sensed, unactuated DoFs named NAME.x .y .z [m] and NAME.rx
/// .ry .rz [rotation vector, rad], in the world. The rotation's box is +-1.5 pi per component: wide
/// enough for q* to follow a turn through pi, where the tracker's own reading jumps to -pi.
struct TrackedPalm {
  std::string name{"palm"};
  double position_lower{-1.0};  ///< m, box of q* in x, y and z
  double position_upper{1.0};   ///< m
};

}  // namespace haptic::core
