#include "haptic/core/projection/block_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace haptic::core {

namespace {

/// Has `part` changed? Writes it. Bits decide, so that a NaN is not new in every tick.
bool take(const VecX& all, int first, VecX& part) noexcept {
  const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(part.size());
  if (std::memcmp(all.data() + first, part.data(), bytes) == 0) return false;
  std::memcpy(part.data(), all.data() + first, bytes);
  return true;
}

}  // namespace

BlockRenderer::Part::Part(RendererKind kind, const ProjectionModel& part, const MapBlock& block)
    : model(part),
      renderer(kind, model),
      at(block),
      n_q(block.kinematics->layout().n_q()),
      n_a(block.kinematics->layout().n_a()),
      n_x(block.kinematics->space().n_x()),
      q(VecQ::Zero(n_q)),
      x_probe(VecX::Zero(n_x)),
      x(VecX::Zero(n_x)),
      dx(VecX::Zero(n_x)),
      J(MatXQ::Zero(n_x, n_q)),
      stiffness(VecA::Zero(n_a)) {
  out.q_star = q;
}

void BlockRenderer::Part::project(const Probe& probe, const VecX& all_x, const VecX& all_dx,
                                  const VecA& all_stiffness, bool proxy_changed) noexcept {
  q = probe.q.segment(at.first_q, n_q);
  x_probe = probe.x_probe.segment(at.first_x, n_x);
  J = probe.J.block(at.first_x, at.first_q, n_x, n_q);
  dx = all_dx.segment(at.first_x, n_x);
  stiffness = all_stiffness.segment(at.first_a, n_a);
  const bool changed = (proxy_changed || !seen) && (take(all_x, at.first_x, x) || !seen);
  seen = true;
  renderer.project(Probe{q, x_probe, J}, x, dx, stiffness, changed, out);
}

BlockRenderer::BlockRenderer(RendererKind kind, const ProjectionModel& model)
    : kind_(kind), model_(model) {
  if (!model_.has_parts()) {
    whole_.emplace(kind, model_);
    return;
  }
  for (const MapBlock& block : model_.kinematics().blocks()) {
    parts_.emplace_back(kind, model_.part(block), block);
  }
}

void BlockRenderer::change(RendererKind kind) noexcept {
  kind_ = kind;
  if (whole_) whole_.emplace(kind, model_);
  for (Part& part : parts_) {
    part.renderer = Renderer(kind, part.model);
    part.seen = false;
  }
}

void BlockRenderer::project(const Probe& probe, const VecX& x, const VecX& dx,
                            const VecA& stiffness, bool proxy_changed, Projection& out) noexcept {
  if (whole_) {
    whole_->project(probe, x, dx, stiffness, proxy_changed, out);
    return;
  }
  out.q_star.resize(probe.q.size());
  out.status = ProjectionStatus::kNone;
  out.condition = out.storage = 0.0;
  double squares = 0.0;
  for (Part& part : parts_) {
    part.project(probe, x, dx, stiffness, proxy_changed);
    out.q_star.segment(part.at.first_q, part.n_q) = part.out.q_star;
    out.status = std::max(out.status, part.out.status);  // in the order of their gravity
    out.condition = std::max(out.condition, part.out.condition);
    out.storage += part.out.storage;
    squares += part.out.residual * part.out.residual;
  }
  out.residual = std::sqrt(squares);
}

void BlockRenderer::reset() noexcept {
  if (whole_) whole_->reset();
  for (Part& part : parts_) {
    part.renderer.reset();
    part.seen = false;
  }
}

}  // namespace haptic::core
