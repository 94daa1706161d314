#include "haptic/core/passivity/direction_guard.hpp"

#include <algorithm>

#include "haptic/core/contacts/contact_leverage.hpp"
#include "haptic/core/rendering/per_contact.hpp"

namespace haptic::core {

DirectionGuard::DirectionGuard(const ProjectionModel& model, const VecA& stiffness)
    : stiffness_(stiffness.size() == 0 ? VecA(VecA::Ones(model.layout().n_a())) : stiffness) {
  for (const MapBlock& at : model.blocks()) {
    blocks_.push_back({at, model.has_blocks() ? model.of(at) : model,
                       LeastSquares(at.n_x(), at.kinematics->layout(), model.coupling())});
    blocks_.back().band = contact_band(blocks_.back().model);
    blocks_.back().by_joint = contacts_by_joint(blocks_.back().model);
  }
}

double DirectionGuard::share(const Probe& probe, const VecX& dx, const VecA& tau_a) noexcept {
  double towards = 0.0, share = 1.0;
  for (Block& block : blocks_) {
    block.dx = dx.segment(block.at.first_x, block.at.n_x());
    if ((block.dx.array() == 0.0).all()) continue;
    block.J = probe.J.block(block.at.first_x, block.at.first_q, block.at.n_x(), block.at.n_q());
    const TaskMetric& metric = block.model.metric();
    metric.weigh(block.J);
    const VecX bare = block.dx;
    metric.weigh(block.dx);
    block.stiffness = stiffness_.segment(block.at.first_a, block.at.n_a());
    block.solver.solve(block.J, block.dx, block.stiffness);
    const VecA tau = tau_a.segment(block.at.first_a, block.at.n_a());
    towards += tau.dot(block.solver.dq_a());
    // With several fingers one would take the force of all.
    const bool one_finger = blocks_.size() == 1 && block.at.kinematics->mechanisms().size() <= 1;
    if (!one_finger || block.solver.status() != ProjectionStatus::kExact) continue;
    ContactView contacts = probe.contacts;
    contacts.first_x = block.at.first_x;
    for_each_contact(block.model, contacts, bare, block.by_joint, block.out,
                     [&](VecX& out, double depth, int) {
                       metric.weigh(out);
                       const VecA way = block.solver.also(block.J, out);
                       if (!(tau.dot(way) < 0.0)) return;
                       const double reached = leverage(block.solver, way);
                       share = std::min(share, slack_at(depth, block.band, reached));
                     });
  }
  // tau_a^T (S J^+ dx) >= 0: the force does not leave the proxy's side as the finger feels it.
  return towards >= 0.0 ? share : 0.0;
}

}  // namespace haptic::core
