#include "haptic/core/projection/direction_guard.hpp"

#include <algorithm>

namespace haptic::core {

DirectionGuard::DirectionGuard(const ProjectionModel& model, const VecA& stiffness)
    : stiffness_(stiffness.size() == 0 ? VecA(VecA::Ones(model.layout().n_a())) : stiffness) {
  for (const MapBlock& at : model.blocks()) {
    blocks_.push_back({at, model.metric().of(at.first_x, at.n_x()),
                       LeastSquares(at.n_x(), at.kinematics->layout(), model.coupling())});
  }
}

bool DirectionGuard::allows(const Probe& probe, const VecX& dx, const VecA& tau_a) noexcept {
  double towards = 0.0;
  for (Block& block : blocks_) {
    block.dx = dx.segment(block.at.first_x, block.at.n_x());
    if ((block.dx.array() == 0.0).all()) continue;
    block.J = probe.J.block(block.at.first_x, block.at.first_q, block.at.n_x(), block.at.n_q());
    block.metric.weigh(block.dx);
    block.metric.weigh(block.J);
    block.stiffness = stiffness_.segment(block.at.first_a, block.at.n_a());
    block.solver.solve(block.J, block.dx, block.stiffness);
    towards += tau_a.segment(block.at.first_a, block.at.n_a()).dot(block.solver.dq_a());
  }
  // tau_a^T (S J^+ dx) >= 0: the force does not leave the proxy's side as the finger feels it.
  return towards >= 0.0;
}

}  // namespace haptic::core
