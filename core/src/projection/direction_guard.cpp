#include "haptic/core/projection/direction_guard.hpp"

#include <algorithm>

namespace haptic::core {

DirectionGuard::Block::Block(const Kinematics& kinematics, const MapBlock& block,
                             const TaskMetric& of_block,
                             const std::shared_ptr<const StiffnessCoupling>& coupling)
    : metric(of_block),
      at(block),
      n_q(kinematics.layout().n_q()),
      n_a(kinematics.layout().n_a()),
      n_x(kinematics.space().n_x()),
      solver(n_x, kinematics.layout(), coupling) {}

DirectionGuard::DirectionGuard(const ProjectionModel& model, const VecA& stiffness)
    : stiffness_(stiffness.size() == 0 ? VecA(VecA::Ones(model.layout().n_a())) : stiffness) {
  const Kinematics& kinematics = model.kinematics();
  if (!model.has_blocks()) {
    blocks_.emplace_back(kinematics, MapBlock{&kinematics, 0, 0, 0}, model.metric(),
                         model.coupling());
    return;
  }
  for (const MapBlock& block : kinematics.blocks()) {
    const int n_x = block.kinematics->space().n_x();
    blocks_.emplace_back(*block.kinematics, block, model.metric().of(block.first_x, n_x),
                         model.coupling());
  }
}

bool DirectionGuard::allows(const Probe& probe, const VecX& dx, const VecA& tau_a) noexcept {
  double towards = 0.0;
  for (Block& block : blocks_) {
    block.dx = dx.segment(block.at.first_x, block.n_x);
    if ((block.dx.array() == 0.0).all()) continue;
    block.J = probe.J.block(block.at.first_x, block.at.first_q, block.n_x, block.n_q);
    block.metric.weigh(block.dx);
    block.metric.weigh(block.J);
    block.stiffness = stiffness_.segment(block.at.first_a, block.n_a);
    block.solver.solve(block.J, block.dx, block.stiffness);
    towards += tau_a.segment(block.at.first_a, block.n_a).dot(block.solver.dq_a());
  }
  // tau_a^T (S J^+ dx) >= 0: the force does not leave the proxy's side as the finger feels it.
  return towards >= 0.0;
}

}  // namespace haptic::core
