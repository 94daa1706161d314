#pragma once
/// The exponential map of rotations and its derivative, smooth through angle 0.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "haptic/core/model/rigid_pose.hpp"

namespace haptic::core {

[[nodiscard]] Eigen::Quaterniond exponential(const Eigen::Vector3d& phi) noexcept;
/// omega = left_jacobian(phi) phi_dot; column i is omega of phi_i.
[[nodiscard]] Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& phi) noexcept;

inline Eigen::Vector3d vector(const Point3& p) noexcept {
  return {p.x, p.y, p.z};
}
/// Normalised. The factories refuse the zero quaternion before it gets here.
inline Eigen::Quaterniond quaternion(const UnitQuaternion& q) noexcept {
  return Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized();
}

}  // namespace haptic::core
