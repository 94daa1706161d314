#include "haptic/core/projection/direction_guard.hpp"

namespace haptic::core {

DirectionGuard::DirectionGuard(const Kinematics& kinematics)
    : kinematics_(&kinematics), solver_(kinematics.space().n_x(), kinematics.layout()) {}

bool DirectionGuard::allows(const Probe& probe, const VecX& dx, const VecA& tau_a) noexcept {
  solver_.solve(probe.J, dx, VecA::Ones(kinematics_->layout().n_a()));
  // tau_a^T (S J^+ dx) >= 0: the force does not leave the proxy's side as the finger feels it.
  return tau_a.dot(solver_.dq_a()) >= 0.0;
}

}  // namespace haptic::core
