#include "haptic/core/projection/direction_guard.hpp"

namespace haptic::core {

DirectionGuard::DirectionGuard(const ProjectionModel& model, const VecA& stiffness)
    : model_(model),
      stiffness_(stiffness.size() == 0 ? VecA(VecA::Ones(model.layout().n_a())) : stiffness),
      solver_(model.n_x(), model.layout()) {}

bool DirectionGuard::allows(const Probe& probe, const VecX& dx, const VecA& tau_a) noexcept {
  solver_.solve(model_.metric().weighed(probe.J, J_W_), model_.metric().weighed(dx, dx_W_),
                stiffness_);
  // tau_a^T (S J^+ dx) >= 0: the force does not leave the proxy's side as the finger feels it.
  return tau_a.dot(solver_.dq_a()) >= 0.0;
}

}  // namespace haptic::core
