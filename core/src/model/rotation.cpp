#include "rotation.hpp"

#include <cmath>
#include <numbers>

namespace haptic::core {

namespace {

/// J_l = I + a [phi] + b [phi]^2.
struct Coefficients {
  double a, b;
};

Coefficients coefficients(double theta) noexcept {
  const double t2 = theta * theta;
  // Below 0.2 the closed forms cancel (eps/theta^2); the series' first term left out is < 1e-13.
  if (theta < 0.2) {
    return {1.0 / 2.0 - t2 * (1.0 / 24.0 - t2 * (1.0 / 720.0 - t2 * (1.0 / 40320.0))),
            1.0 / 6.0 - t2 * (1.0 / 120.0 - t2 * (1.0 / 5040.0 - t2 * (1.0 / 362880.0)))};
  }
  const double half = std::sin(0.5 * theta);
  return {2.0 * half * half / t2, (theta - std::sin(theta)) / (t2 * theta)};
}

Eigen::Matrix3d cross(const Eigen::Vector3d& v) noexcept {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

}  // namespace

Eigen::Quaterniond exponential(const Eigen::Vector3d& phi) noexcept {
  const double theta = phi.norm();
  // sin(theta/2)/theta; the series is exact to rounding below 1e-3.
  const double s = theta < 1e-3 ? 0.5 - theta * theta / 48.0 : std::sin(0.5 * theta) / theta;
  return {std::cos(0.5 * theta), s * phi.x(), s * phi.y(), s * phi.z()};
}

Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& phi) noexcept {
  const Coefficients c = coefficients(phi.norm());
  const Eigen::Matrix3d P = cross(phi);
  return Eigen::Matrix3d::Identity() + c.a * P + c.b * P * P;
}

Eigen::Vector3d rotation_vector(const UnitQuaternion& orientation) noexcept {
  const double sign = orientation.w < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d v(sign * orientation.x, sign * orientation.y, sign * orientation.z);
  const double length = v.norm();
  const double w = sign * orientation.w;
  if (!std::isfinite(length) || !std::isfinite(w) || (length == 0.0 && w == 0.0)) {
    return Eigen::Vector3d::Zero();
  }
  // atan2 takes any scale, so the norm need not be 1.
  const double angle_per_length =
      length < 1e-9 * w ? 2.0 / w : 2.0 * std::atan2(length, w) / length;
  return angle_per_length * v;
}

Eigen::Vector3d nearest_rotation_vector(const Eigen::Vector3d& phi,
                                        const Eigen::Vector3d& near) noexcept {
  const double theta = phi.norm();
  if (!(theta > 0.0)) return phi;
  // Same axis, angles theta + 2 pi k: the nearest is the one whose angle is nearest to near's
  // component along the axis.
  const double along = phi.dot(near) / theta;
  const double turns = std::round((along - theta) / (2.0 * std::numbers::pi));
  return phi * (1.0 + 2.0 * std::numbers::pi * turns / theta);
}

}  // namespace haptic::core
