#include "haptic/core/projection/direction_guard.hpp"

#include <algorithm>

namespace haptic::core {

DirectionGuard::Part::Part(const Kinematics& kinematics, const MapBlock& block,
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
  if (!model.has_parts()) {
    parts_.emplace_back(kinematics, MapBlock{&kinematics, 0, 0, 0}, model.metric(),
                        model.coupling());
    return;
  }
  for (const MapBlock& block : kinematics.blocks()) {
    const int n_x = block.kinematics->space().n_x();
    parts_.emplace_back(*block.kinematics, block, model.metric().part(block.first_x, n_x),
                        model.coupling());
  }
}

bool DirectionGuard::allows(const Probe& probe, const VecX& dx, const VecA& tau_a) noexcept {
  double towards = 0.0;
  for (Part& part : parts_) {
    part.dx = dx.segment(part.at.first_x, part.n_x);
    if ((part.dx.array() == 0.0).all()) continue;
    part.J = probe.J.block(part.at.first_x, part.at.first_q, part.n_x, part.n_q);
    part.metric.weigh(part.dx);
    part.metric.weigh(part.J);
    part.stiffness = stiffness_.segment(part.at.first_a, part.n_a);
    part.solver.solve(part.J, part.dx, part.stiffness);
    towards += tau_a.segment(part.at.first_a, part.n_a).dot(part.solver.dq_a());
  }
  // tau_a^T (S J^+ dx) >= 0: the force does not leave the proxy's side as the finger feels it.
  return towards >= 0.0;
}

}  // namespace haptic::core
