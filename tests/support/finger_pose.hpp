#pragma once
/// One pose of the finger exoskeleton with its linkage's inner coordinates.

#include <algorithm>
#include <complex>

#include "core/src/model/finger_linkage.hpp"

namespace haptic::core {

struct FingerPose {
  MapStatus status{MapStatus::kCannotClose};
  double q_o1{0.0}, q_o2{0.0};  ///< rad
  double c1{0.0}, c2{0.0};      ///< slider positions, m
  double closure{0.0};          ///< largest distance by which the two rods miss their ends, m
};

inline FingerPose finger_pose(const FingerDimensions& dimensions, double l_x, double q_B) {
  using Complex = std::complex<double>;
  LinkagePose p;
  if (!FingerLinkage(dimensions).pose(l_x, q_B, p)) return {};
  const auto point = [](Point2 of) { return Complex(of.x, of.y); };
  const Complex P = point(dimensions.rail_origin) + std::polar(l_x, dimensions.rail_angle);
  const Complex u1 = std::polar(1.0, -p.q1), u2 = std::polar(1.0, -(p.q1 + p.q2));
  const Complex turn = std::polar(1.0, q_B);
  const Complex D = P + turn * point(dimensions.body_d), E = P + turn * point(dimensions.body_e);
  const Complex miss1 = D - Complex(p.c1, dimensions.rod1) * u1;
  const Complex miss2 = E - dimensions.proximal_phalanx * u1 - Complex(p.c2, dimensions.rod2) * u2;
  return {MapStatus::kOk, p.q1, p.q2, p.c1, p.c2, std::max(std::abs(miss1), std::abs(miss2))};
}

}  // namespace haptic::core
