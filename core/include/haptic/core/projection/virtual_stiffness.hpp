#pragma once
/// The paper's Z_x = z_x I for the baselines Eq. (1), (4): the actuator's stiffness with the
/// average scale of J_a factored out (section VI.C).

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

/// Unit of force per unit of x. `stiffness`: n_a. 0 if J_a = 0.
[[nodiscard]] inline double virtual_stiffness(const VecA& stiffness, double mean_J_a) noexcept {
  return mean_J_a > 0.0 ? stiffness.mean() / (mean_J_a * mean_J_a) : 0.0;
}

/// q* with S q* = q_a + Z_q^{-1} tau_a and the sensed part as it is: the anchor that makes
/// tau_a = Z_q S(q* - q). A DoF of stiffness 0 has no anchor but its own position, and no force.
inline void anchor_for(const VecA& tau_a, const VecA& stiffness, const DofLayout& layout,
                       const VecQ& q, VecQ& q_star) noexcept {
  q_star = q;
  for (int i = 0; i < layout.n_a(); ++i) {
    if (stiffness[i] > 0.0) q_star[layout.actuated(i)] += tau_a[i] / stiffness[i];
  }
}

}  // namespace haptic::core
