#include "tests/report/best_force.hpp"

#include <algorithm>

namespace haptic::report {

core::VecX lever(const core::MatXQ& J) {
  const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
  return (core::VecX(2) << J(1, 1) / det, -J(0, 1) / det).finished();
}

double BestForce::at(const core::PlaneSet& walls, const core::VecX& x_probe, const core::VecX& w) {
  walls_.set(walls, x_probe);
  static_cast<void>(walls_.project(x_probe, x_));
  const core::VecX dx = x_ - x_probe;
  const double tau = std::clamp(stiffness_ * w.dot(dx), -limit_, limit_);
  for (int i = 0; i < walls.size(); ++i) {
    const auto n = walls.normals.col(i);
    if (n.dot(x_probe) - walls.offsets[i] > kContactBand && n.dot(w) * tau > 0.0) return 0.0;
  }
  return tau;
}

}  // namespace haptic::report
