#pragma once
/// Maps for tests: any smooth function with its Jacobian by differences, and a hand.

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "haptic/core/model/kinematics.hpp"

namespace haptic::core::samples {

/// x = f(q) with J = df/dq, both as given; counts how often it was asked.
class FunctionMap final : public Kinematics {
 public:
  using Function = std::function<VecX(const VecQ&)>;
  using Jacobian = std::function<MatXQ(const VecQ&)>;

  FunctionMap(std::vector<DofSpec> dofs, std::vector<Coordinate> coordinates, Function f,
              Jacobian J)
      : Kinematics(std::move(dofs), ConfigurationSpace(std::move(coordinates))),
        f_(std::move(f)),
        J_(std::move(J)) {}

  MapStatus evaluate(const VecQ& q, VecX& x, MatXQ& J) const noexcept override {
    ++evaluations;
    x = f_(q);
    J = J_(q);
    return MapStatus::kOk;
  }
  MapStatus second_order(const VecQ&, int, MatXQ&) const noexcept override {
    return MapStatus::kCannotClose;
  }

  mutable int evaluations{0};

 private:
  Function f_;
  Jacobian J_;
};

inline std::vector<DofSpec> dofs(int n_q, int n_a, double half_width, Unit unit = Unit::kRadian) {
  std::vector<DofSpec> list;
  for (int i = 0; i < n_q; ++i) {
    list.push_back({"q" + std::to_string(i), unit, i < n_a, -half_width, half_width});
  }
  return list;
}

inline std::vector<Coordinate> coordinates(int n_x, Unit unit = Unit::kMetre,
                                           CoordinateKind kind = CoordinateKind::kLinear) {
  std::vector<Coordinate> list;
  for (int i = 0; i < n_x; ++i) list.push_back({"x" + std::to_string(i), unit, kind});
  return list;
}

/// The map of tests/report/STUDY.md#curved-wide-map: curved, wide, q_a = (q0, q1), q_n = q2.
inline FunctionMap wide_map(double half_width = 1.0) {
  const Eigen::Matrix<double, 2, 3> A =
      (Eigen::Matrix<double, 2, 3>() << 1, .6, -.4, .3, 1.2, .8).finished();
  return FunctionMap(
      dofs(3, 2, half_width), coordinates(2),
      [A](const VecQ& q) {
        const Eigen::Vector2d z = A * q;
        return VecX(
            (VecX(2) << std::sin(z[0]) + .3 * q[1] * q[2], z[1] + .2 * z[0] * z[0]).finished());
      },
      [A](const VecQ& q) {
        const Eigen::Vector2d z = A * q;
        MatXQ J(2, 3);
        J.row(0) = std::cos(z[0]) * A.row(0);
        J(0, 1) += .3 * q[2];
        J(0, 2) += .3 * q[1];
        J.row(1) = A.row(1) + .4 * z[0] * A.row(0);
        return J;
      });
}

/// The hand of tests/report/STUDY.md#larger-devices: a tracked wrist (position, rotation vector)
/// and fingers of four joints (abduction, three flexions), known by three points per finger. Sensed
/// wrist, actuated flexions of the first joint.
inline FunctionMap hand(int fingers) {
  const int n_q = 6 + 4 * fingers, n_x = 9 * fingers;
  std::vector<DofSpec> list;
  for (int i = 0; i < 3; ++i) list.push_back({"p", Unit::kMetre, false, -0.1, 0.1});
  for (int i = 0; i < 3; ++i) list.push_back({"r", Unit::kRadian, false, -0.6, 0.6});
  for (int f = 0; f < fingers; ++f) {
    list.push_back({"abduction", Unit::kRadian, false, -0.35, 0.35});
    list.push_back({"mcp", Unit::kRadian, true, 0.0, 1.57});
    list.push_back({"pip", Unit::kRadian, false, 0.0, 1.75});
    list.push_back({"dip", Unit::kRadian, false, 0.0, 1.2});
  }
  const FunctionMap::Function f = [fingers, n_x](const VecQ& q) {
    using Eigen::AngleAxisd, Eigen::Vector3d;
    VecX x(n_x);
    const Vector3d w = q.segment<3>(3);
    const Eigen::Matrix3d wrist = w.norm() > 0.0
                                      ? AngleAxisd(w.norm(), w.normalized()).toRotationMatrix()
                                      : Eigen::Matrix3d::Identity();
    constexpr double kLinks[3] = {0.045, 0.025, 0.020};
    for (int k = 0; k < fingers; ++k) {
      const VecQ joint = q.segment(6 + 4 * k, 4);
      Vector3d at(0.09, 0.02 * (k - 0.5 * (fingers - 1)), 0.0);
      Eigen::Matrix3d R = AngleAxisd(joint[0], Vector3d::UnitZ()).toRotationMatrix();
      for (int link = 0; link < 3; ++link) {
        R = R * AngleAxisd(joint[1 + link], Vector3d::UnitY()).toRotationMatrix();
        at += R * Vector3d(kLinks[link], 0.0, 0.0);
        x.segment<3>(9 * k + 3 * link) = Vector3d(q.head<3>()) + wrist * at;
      }
    }
    return x;
  };
  const FunctionMap::Jacobian J = [f, n_q, n_x](const VecQ& q) {
    MatXQ result(n_x, n_q);
    for (int k = 0; k < n_q; ++k) {
      constexpr double h = 1e-6;
      VecQ up = q, down = q;
      up[k] += h;
      down[k] -= h;
      result.col(k) = (f(up) - f(down)) / (2.0 * h);
    }
    return result;
  };
  return FunctionMap(std::move(list), coordinates(n_x), f, J);
}

}  // namespace haptic::core::samples
