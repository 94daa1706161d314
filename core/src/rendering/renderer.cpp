#include "haptic/core/rendering/renderer.hpp"

#include "haptic/core/names.hpp"

namespace haptic::core {

namespace {

using Any = std::variant<Baseline, SubspaceLinear, SubspaceExact, PerContact>;

Any make(RendererKind kind, const ProjectionModel& model) {
  if (kind == RendererKind::kSubspaceLinear) return SubspaceLinear(model);
  if (kind == RendererKind::kSubspaceExact) return SubspaceExact(model);
  if (kind == RendererKind::kPerContact) return PerContact(model);
  return Baseline(kind, model);
}

}  // namespace

std::string_view name(RendererKind kind) noexcept {
  static constexpr std::array<std::string_view, 6> kNames{
      "UNKNOWN", "standard", "null_space", "subspace_linear", "subspace_exact", "per_contact"};
  return name_of(kind, kNames);
}

Renderer::Renderer(RendererKind kind, const ProjectionModel& model)
    : kind_(kind), renderer_(make(kind, model)) {}

void Renderer::project(const Probe& probe, const VecX& x, const VecX& dx, const VecA& stiffness,
                       bool proxy_changed, Projection& out) noexcept {
  out.storage = out.residual = out.condition = out.damping = 0.0;
  out.contradicted = out.between = false;
  const auto project = [&](auto& renderer) {
    renderer.project(probe, x, dx, stiffness, proxy_changed, out);
  };
  std::visit(project, renderer_);
}

bool Renderer::widen(const Probe& probe, const VecA& stiffness, const ProxyError& error,
                     VecA& force) noexcept {
  auto* per_contact = std::get_if<PerContact>(&renderer_);
  return per_contact == nullptr || per_contact->widen(probe, stiffness, error, force);
}

void Renderer::release() noexcept {
  if (auto* exact = std::get_if<SubspaceExact>(&renderer_)) exact->release();
}

void Renderer::reset() noexcept {
  if (auto* exact = std::get_if<SubspaceExact>(&renderer_)) exact->reset();
  if (auto* linear = std::get_if<SubspaceLinear>(&renderer_)) linear->reset();
  if (auto* per_contact = std::get_if<PerContact>(&renderer_)) per_contact->reset();
}

}  // namespace haptic::core
