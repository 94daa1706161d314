#include "haptic/core/rendering/force_error.hpp"

#include <cmath>

#include "haptic/core/rendering/baselines.hpp"

namespace haptic::core {

ForceError::ForceError(const ProjectionModel& model)
    : n_a_(model.layout().n_a()), prior_(model.prior().has_value()) {
  for (const MapBlock& at : model.blocks()) {
    blocks_.push_back({at, model.has_blocks() ? model.of(at) : model,
                       LeastSquares(at.n_x(), at.kinematics->layout(), model.coupling())});
  }
}

/// A contact of several blocks carries the error of one into the others.
double ForceError::distance(const Block& block, const Contacts& contacts,
                            const ProxyError& error) const noexcept {
  double sum = 0.0;
  bool named = false;
  for (int i = 0; i < contacts.size(); ++i) {
    const auto into = contacts.into.col(i);
    const bool here = !into.segment(block.at.first_x, block.at.n_x()).isZero(0.0);
    named = named || here;
    if (error.of.size() == 0) continue;
    bool shared = false;
    for (const Block& other : blocks_) {
      shared = shared || (&other != &block && here &&
                          !into.segment(other.at.first_x, other.at.n_x()).isZero(0.0));
    }
    if (shared) return error.of.sum() + error.everywhere;
    if (here) sum += error.of[i];
  }
  return named ? sum + error.everywhere : 0.0;
}

bool ForceError::at(const Renders& renders, const Contacts& contacts, const ProxyError& error,
                    VecA& force) noexcept {
  if (prior_) return false;
  force.setZero(n_a_);
  if (error.none()) return true;
  if (renders.kind == RendererKind::kSubspaceExact) return false;  // J at q* is of first order
  BlockSet bit = 1;
  for (auto b = blocks_.begin(); b != blocks_.end(); ++b, bit <<= 1) {
    Block& block = *b;
    const double off = distance(block, contacts, error);
    if (off < ProxyError::kNothing) continue;
    const int n_a = block.at.n_a();
    if ((renders.known & bit) != 0) {
      J_ = renders.J.block(block.at.first_x, block.at.first_q, block.at.n_x(), block.at.n_q());
    } else {
      q_ = renders.q.segment(block.at.first_q, block.at.n_q());
      if (block.at.kinematics->evaluate(q_, x_, J_) != MapStatus::kOk) return false;
    }
    block.model.metric().weigh(J_);
    const VecA stiffness = renders.stiffness.segment(block.at.first_a, n_a);
    const bool baseline =
        renders.kind == RendererKind::kStandard || renders.kind == RendererKind::kNullSpace;
    // Along one contact its direction alone counts; else the longest row.
    bool along = error.along >= 0;
    if (along) {
      along_ = contacts.into.col(error.along).segment(block.at.first_x, block.at.n_x());
      block.model.metric().weigh(along_);
      along = !along_.isZero(0.0);
    }
    const double straight = along ? error.of[error.along] : 0.0;
    const double z_x =
        baseline ? virtual_stiffness(stiffness, block.model.mean_actuated_jacobian()) : 0.0;
    VecA moved;
    if (!baseline) {
      x_.setZero(block.at.n_x());
      block.solver.solve(J_, x_, stiffness);
      if (block.solver.status() != ProjectionStatus::kExact) return false;
      if (along) moved = block.solver.also(J_, along_);
    }
    for (int a = 0; a < n_a; ++a) {
      double row = 0.0, part = 0.0;  // of the longest way, and of the one along the contact
      if (baseline) {
        const auto column = J_.col(block.model.layout().actuated(a));
        part = row = z_x * column.norm();
        if (along && renders.kind == RendererKind::kStandard) {
          part = z_x * std::abs(column.dot(along_));
        }
      } else {
        VecA pull = VecA::Zero(n_a);
        if (renders.Z_q.size() > 0) {
          pull = renders.Z_q.row(a).transpose();
        } else {
          pull[a] = stiffness[a];
        }
        if (along) part = std::abs(pull.dot(moved));
        row = off > straight ? block.solver.felt(pull) : 0.0;
      }
      force[block.at.first_a + a] = row * (off - straight) + part * straight;
    }
  }
  return true;
}

}  // namespace haptic::core
