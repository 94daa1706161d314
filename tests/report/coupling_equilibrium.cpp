#include "tests/report/coupling_equilibrium.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "haptic/core/rendering/coupling_metric.hpp"

namespace haptic::report {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

struct Pose {
  core::VecQ q{};
  Matrix2d J{};
};

std::optional<Pose> pose_at(const core::Kinematics& finger, const Vector2d& x) {
  Pose pose;
  core::VecX f;
  core::MatXQ J;
  if (finger.inverse(core::VecX(x), pose.q) != core::InverseStatus::kExact ||
      finger.evaluate(pose.q, f, J) != core::MapStatus::kOk) {
    return std::nullopt;
  }
  pose.J = J;
  return pose;
}

/// tau_a with the probe at x.
std::optional<double> force(const core::Kinematics& finger, const Press& press, const Vector2d& x,
                            std::optional<double> softness, Vector2d& w) {
  const std::optional<Pose> pose = pose_at(finger, x);
  if (!pose) return std::nullopt;
  w = pose->J.inverse().row(0).transpose();  // (S J^{-1})^T
  const double depth = press.normal.dot(x - press.pose);
  if (depth <= 0.0) return 0.0;
  Vector2d along = press.normal;  // W^{-1} n
  if (softness) {
    const auto W = core::coupling_metric(finger, {}, pose->q,
                                         core::VecA::Constant(1, press.stiffness), *softness);
    if (!W) return std::nullopt;
    along = Matrix2d(*W).inverse() * press.normal;
  }
  return -press.stiffness * w.dot(along) * depth / press.normal.dot(along);
}

/// What pulls the finger with the probe at x, N m.
std::optional<Vector2d> pull(const core::Kinematics& finger, const Press& press, const Vector2d& x,
                             std::optional<double> softness) {
  Vector2d w;
  const std::optional<double> tau_a = force(finger, press, x, softness, w);
  if (!tau_a) return std::nullopt;
  const Vector2d meant = press.pose + press.penetration * press.normal;
  return Vector2d(kHandStiffness * (meant - x) + w * *tau_a);
}

/// d pull/dx, inside of the plane as at the plane itself.
std::optional<Matrix2d> slope(const core::Kinematics& finger, const Press& press, const Vector2d& x,
                              std::optional<double> softness) {
  constexpr double kStep = 1e-6;
  Matrix2d A;
  for (int k = 0; k < 2; ++k) {
    const Vector2d step = kStep * Vector2d::Unit(k);
    const auto ahead = pull(finger, press, x + step, softness);
    const auto behind = pull(finger, press, x - step, softness);
    if (!ahead || !behind) return std::nullopt;
    A.col(k) = (*ahead - *behind) / (2.0 * kStep);
  }
  return A;
}

}  // namespace

std::optional<Rest> full_device(const core::Kinematics& finger, const Press& press) {
  const std::optional<Pose> on_plane = pose_at(finger, press.pose);
  if (!on_plane) return std::nullopt;
  const double K = press.stiffness / on_plane->J.col(0).squaredNorm();
  // Two springs in a row along the normal.
  const double depth = press.penetration * kHandStiffness / (kHandStiffness + K);
  const std::optional<Pose> rest = pose_at(finger, press.pose + depth * press.normal);
  if (!rest) return std::nullopt;
  return Rest{-K * depth * rest->J.col(0).dot(press.normal), depth};
}

std::optional<Rest> underactuated(const core::Kinematics& finger, const Press& press,
                                  std::optional<double> softness) {
  // The finger as a damper of 1 N m s/rad, by implicit Euler with steps short enough that what is
  // unstable grows instead of being solved for.
  Vector2d x = press.pose;
  for (int i = 0; i < 4000; ++i) {
    const auto torque = pull(finger, press, x, softness);
    if (!torque) return std::nullopt;
    if (torque->norm() < 1e-12) break;
    const auto A = slope(finger, press, x, softness);
    if (!A) return std::nullopt;
    const Matrix2d symmetric = 0.5 * (*A + A->transpose());
    const double mean = 0.5 * symmetric.trace();
    const double largest =
        mean + std::hypot(0.5 * (symmetric(0, 0) - symmetric(1, 1)), symmetric(0, 1));
    const double dt =
        largest > 0.0 ? std::min(0.5 / kHandStiffness, 0.2 / largest) : 0.5 / kHandStiffness;
    x += (Matrix2d::Identity() / dt - *A).inverse() * *torque;
  }
  Vector2d w;
  const auto torque = pull(finger, press, x, softness);
  const auto tau_a = force(finger, press, x, softness, w);
  if (!torque || !tau_a || torque->norm() > 1e-9) return std::nullopt;
  return Rest{*tau_a, press.normal.dot(x - press.pose)};
}

}  // namespace haptic::report
