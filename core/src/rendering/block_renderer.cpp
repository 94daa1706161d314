// A hand is several small problems instead of one large one, and most of them did not change. A
// block is solved again only if its part of x, q, dx, J or stiffness changed in some bit (bits, so
// that a NaN is not "new" in every tick). Under Eq. (6) without a prior the answer depends on x
// alone, so a held block costs nothing while the finger moves.
#include "haptic/core/rendering/block_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace haptic::core {

namespace {

/// Has `mine` changed? Writes it. Bits decide, so that a NaN is not new in every tick.
bool take(const VecX& all, int first, VecX& mine) noexcept {
  const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(mine.size());
  if (std::memcmp(all.data() + first, mine.data(), bytes) == 0) return false;
  std::memcpy(mine.data(), all.data() + first, bytes);
  return true;
}

/// tr(Z_q^{-1} J_a^T Z_x J_a) of the block of `model` that begins at row `x` and column `q` of J
/// and actuator `a`, at least 1.
double most_displayed(const ProjectionModel& model, const MatXQ& J, int x, int q, int a,
                      const VecA& all_stiffness) noexcept {
  const DofLayout& layout = model.layout();
  const VecA stiffness = all_stiffness.segment(a, layout.n_a());
  const double z_x = virtual_stiffness(stiffness, model.mean_actuated_jacobian());
  double sum = 0.0;
  for (int i = 0; i < layout.n_a(); ++i) {
    if (!(stiffness[i] > 0.0)) continue;  // no force there
    VecX column = J.col(q + layout.actuated(i)).segment(x, model.n_x());
    model.metric().weigh(column);
    sum += column.squaredNorm() / stiffness[i];
  }
  return std::isfinite(z_x * sum) ? std::max(1.0, z_x * sum) : 1.0;
}

}  // namespace

BlockRenderer::Block::Block(RendererKind kind, const ProjectionModel& of_block,
                            const MapBlock& in_map)
    : model(of_block),
      renderer(kind, model),
      at(in_map),
      n_q(at.n_q()),
      n_a(at.n_a()),
      n_x(at.n_x()),
      q(VecQ::Zero(n_q)),
      x_probe(VecX::Zero(n_x)),
      x(VecX::Zero(n_x)),
      dx(VecX::Zero(n_x)),
      J(MatXQ::Zero(n_x, n_q)),
      stiffness(VecA::Zero(n_a)) {
  out.q_star = q;
}

bool BlockRenderer::Block::displaced(const VecX& all_dx) const noexcept {
  const double* first = all_dx.data() + at.first_x;
  return std::any_of(first, first + n_x, [](double d) { return d != 0.0; });
}

void BlockRenderer::Block::project(const Probe& probe, const VecX& all_x, const VecX& all_dx,
                                   const VecA& all_stiffness, bool proxy_changed) noexcept {
  const bool changed = (proxy_changed || !seen) && (take(all_x, at.first_x, x) || !seen);
  seen = true;
  if (held && !changed) return;
  q = probe.q.segment(at.first_q, n_q);
  x_probe = probe.x_probe.segment(at.first_x, n_x);
  J = probe.J.block(at.first_x, at.first_q, n_x, n_q);
  dx = all_dx.segment(at.first_x, n_x);
  stiffness = all_stiffness.segment(at.first_a, n_a);
  ContactView contacts = probe.contacts;
  contacts.first_x = at.first_x;
  contacts.first_a = at.first_a;
  renderer.project(Probe{q, x_probe, J, contacts}, x, dx, stiffness, changed, out);
  held = renderer.kind() == RendererKind::kSubspaceExact && !model.prior() &&
         out.status != ProjectionStatus::kMapFailed && !out.between;
}

BlockRenderer::BlockRenderer(RendererKind kind, const ProjectionModel& model)
    : kind_(kind), model_(model), idle_possible_(!model.prior()) {
  if (!model_.has_blocks()) {
    whole_.emplace(kind, model_);
    return;
  }
  for (const MapBlock& at : model_.kinematics().blocks()) {
    blocks_.emplace_back(kind, model_.of(at), at);
  }
}

void BlockRenderer::change(RendererKind kind) noexcept {
  kind_ = kind;
  if (whole_) whole_.emplace(kind, model_);
  for (Block& block : blocks_) {
    block.renderer = Renderer(kind, block.model);
    block.seen = block.held = false;
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
  out.q_wish.resize(probe.q.size());
  out.condition = out.storage = out.damping = 0.0;
  out.contradicted = out.between = false;
  double squares = 0.0;
  for (Block& block : blocks_) {
    const bool answered = block.held && !proxy_changed;
    if (idle_possible_ && !answered && !block.displaced(dx)) {
      if (block.seen) block.renderer.release();
      block.seen = block.held = false;  // whatever is displaced next is solved
      const double* q = probe.q.data() + block.at.first_q;
      std::copy(q, q + block.n_q, out.q_star.data() + block.at.first_q);
      std::copy(q, q + block.n_q, out.q_wish.data() + block.at.first_q);
      out.status = std::max(out.status, ProjectionStatus::kExact);
      continue;
    }
    block.project(probe, x, dx, stiffness, proxy_changed);
    const VecQ& q_star = block.out.q_star;
    std::copy(q_star.data(), q_star.data() + block.n_q, out.q_star.data() + block.at.first_q);
    const VecQ& wish = block.out.contradicted ? block.out.q_wish : q_star;
    std::copy(wish.data(), wish.data() + block.n_q, out.q_wish.data() + block.at.first_q);
    out.status = std::max(out.status, block.out.status);  // in the order of their gravity
    out.condition = std::max(out.condition, block.out.condition);
    out.storage += block.out.storage;
    out.damping = std::max(out.damping, block.out.damping);
    out.contradicted = out.contradicted || block.out.contradicted;
    out.between = out.between || block.out.between;
    squares += block.out.residual * block.out.residual;
  }
  out.residual = std::sqrt(squares);
}

BlockSet BlockRenderer::reads_J(BlockSet displaced) const noexcept {
  if (kind_ == RendererKind::kSubspaceExact) return 0;
  const BlockSet all = ~BlockSet{0};
  return whole_ || !idle_possible_ ? all : displaced;
}

void BlockRenderer::displayed_bound(const Probe& probe, const VecX& dx, const VecA& stiffness,
                                    VecA& ratio) const noexcept {
  ratio.setOnes(stiffness.size());
  if (displays_Z_q(kind_)) return;
  if (whole_) {
    if ((dx.array() != 0.0).any())
      ratio.setConstant(most_displayed(model_, probe.J, 0, 0, 0, stiffness));
    return;
  }
  for (const Block& block : blocks_) {
    if (!block.displaced(dx)) continue;
    const MapBlock& at = block.at;
    ratio.segment(at.first_a, block.n_a)
        .setConstant(
            most_displayed(block.model, probe.J, at.first_x, at.first_q, at.first_a, stiffness));
  }
}

bool BlockRenderer::widen(const Probe& probe, const VecX& dx, const VecA& stiffness,
                          const ProxyError& error, VecA& force) noexcept {
  const bool exact = error.none() && error.depth.size() == 0 && error.beside == 0;
  if (kind_ != RendererKind::kPerContact || exact) return true;
  // Without a push of its own one actuator answers with a share of what Eq. (8) may be off.
  if (whole_) {
    if ((dx.array() == 0.0).all()) return force.size() == 1 || force.isZero(0.0);
    return whole_->widen(probe, stiffness, error, force);
  }
  for (Block& block : blocks_) {
    VecA part = force.segment(block.at.first_a, block.n_a);
    if (!block.displaced(dx)) {
      if (block.n_a != 1 && !part.isZero(0.0)) return false;
      continue;
    }
    ContactView contacts = probe.contacts;
    contacts.first_x = block.at.first_x;
    contacts.first_a = block.at.first_a;
    const Probe here{block.q, block.x_probe, block.J, contacts};
    if (!block.renderer.widen(here, block.stiffness, error, part)) return false;
    force.segment(block.at.first_a, block.n_a) = part;
  }
  return true;
}

void BlockRenderer::release() noexcept {
  if (whole_) whole_->release();
  for (Block& block : blocks_) block.renderer.release();
}

void BlockRenderer::reset() noexcept {
  if (whole_) whole_->reset();
  for (Block& block : blocks_) {
    block.renderer.reset();
    block.seen = block.held = false;
  }
}

}  // namespace haptic::core
