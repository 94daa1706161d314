#pragma once
/// Gaps of round bodies from the bodies themselves: points are placed by rotations, and their
/// distance is that from a centre, or from an axis.

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

namespace haptic::core::round_bodies {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Two or three coordinates.
using Coordinates = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;
using PerCoordinate = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;

/// A gap with its derivatives.
struct Jet {
  double phi{0.0};
  Coordinates g{};
  PerCoordinate H{};
};
using Body = std::function<Jet(const Coordinates& x)>;

/// The distance of a point at p; `across`: what is left of it if the body is a cylinder. `outside`:
/// 1, or -1 if the body is hollow. Scaled, as contacts are. J = dp/dx, and p bends nowhere.
inline Jet distance(const Matrix3d& across, double radius, double outside, double scale,
                    const Vector3d& p, const PerCoordinate& J) {
  const Vector3d r = across * p;
  const double s = r.norm();
  const Vector3d n = outside * r / s;
  const Matrix3d surface = outside * (across - n * n.transpose()) / s;
  return {scale * outside * (s - radius), scale * J.transpose() * n,
          scale * J.transpose() * surface * J};
}

/// A pad of a finger of two links on a disc around `centre`, or on a sphere whose centre is so far
/// aside of the finger's plane.
inline Body pad(const Vector2d& centre, double radius, double outside, double scale,
                const Vector2d& link, const Vector2d& tip, double aside = 0.0) {
  return [=](const Coordinates& x) {
    const Vector2d first = Eigen::Rotation2Dd(x[0]) * link;
    const Vector2d second = Eigen::Rotation2Dd(x[0] + x[1]) * tip, both = first + second;
    const Vector3d p(both[0] - centre[0], both[1] - centre[1], aside);
    PerCoordinate J = PerCoordinate::Zero(3, 2);
    J.col(0).head<2>() << -both[1], both[0];
    J.col(1).head<2>() << -second[1], second[0];
    Jet jet = distance(Matrix3d::Identity(), radius, outside, scale, p, J);
    const Vector2d n = scale * outside * p.head<2>() / p.norm();
    const double bend = -n.dot(both), last = -n.dot(second);
    jet.H += (Eigen::Matrix2d() << bend, last, last, last).finished();
    return jet;
  };
}

}  // namespace haptic::core::round_bodies
