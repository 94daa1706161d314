#pragma once
/// A rotation vector as the unit quaternion that a tracker would report.

#include "core/src/model/rotation.hpp"

namespace haptic::core {

inline UnitQuaternion unit_quaternion(const Eigen::Vector3d& phi) noexcept {
  const Eigen::Quaterniond q = exponential(phi);
  return {q.x(), q.y(), q.z(), q.w()};
}

}  // namespace haptic::core
