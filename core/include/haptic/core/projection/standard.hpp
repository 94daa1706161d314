#pragma once
/// Eq. (1): tau_a = J_a^T Z_x dx, the standard method, blind to underactuation.

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/projection/projection.hpp"

namespace haptic::core {

class Standard {
 public:
  explicit Standard(const Kinematics& kinematics);
  void project(const Probe& probe, const VecX& dx, const VecA& stiffness, Projection& out) noexcept;

 private:
  const Kinematics* kinematics_;
  double mean_J_a_;
  VecA tau_a_{};
};

}  // namespace haptic::core
