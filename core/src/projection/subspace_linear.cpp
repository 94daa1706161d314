#include "haptic/core/projection/subspace_linear.hpp"

namespace haptic::core {

SubspaceLinear::SubspaceLinear(const Kinematics& kinematics)
    : solver_(kinematics.space().n_x(), kinematics.layout()) {}

void SubspaceLinear::project(const Probe& probe, const VecX& dx, const VecA& stiffness,
                             Projection& out) noexcept {
  solver_.solve(probe.J, dx, stiffness);
  out.q_star = probe.q + solver_.dq();  // Eq. (8)
  out.status = solver_.status();
  out.residual = solver_.residual();
  out.condition = solver_.condition();
}

}  // namespace haptic::core
