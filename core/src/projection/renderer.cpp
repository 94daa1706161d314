#include "haptic/core/projection/renderer.hpp"

namespace haptic::core {

namespace {

using Any = std::variant<Standard, NullSpace, SubspaceLinear, SubspaceExact>;

Any make(RendererKind kind, const Kinematics& kinematics) {
  switch (kind) {
    case RendererKind::kStandard:
      return Standard(kinematics);
    case RendererKind::kNullSpace:
      return NullSpace(kinematics);
    case RendererKind::kSubspaceLinear:
      return SubspaceLinear(kinematics);
    case RendererKind::kSubspaceExact:
      break;
  }
  return SubspaceExact(kinematics);
}

}  // namespace

std::string_view name(RendererKind kind) noexcept {
  switch (kind) {
    case RendererKind::kStandard:
      return "standard";
    case RendererKind::kNullSpace:
      return "null_space";
    case RendererKind::kSubspaceLinear:
      return "subspace_linear";
    case RendererKind::kSubspaceExact:
      return "subspace_exact";
  }
  return "unknown";
}

Renderer::Renderer(RendererKind kind, const Kinematics& kinematics)
    : renderer_(make(kind, kinematics)) {}

RendererKind Renderer::kind() const noexcept {
  return static_cast<RendererKind>(renderer_.index() + 1);
}

void Renderer::project(const Probe& probe, const VecX& x, const VecX& dx, const VecA& stiffness,
                       bool proxy_changed, Projection& out) noexcept {
  if (auto* linear = std::get_if<SubspaceLinear>(&renderer_)) {
    linear->project(probe, dx, stiffness, out);
  } else if (auto* exact = std::get_if<SubspaceExact>(&renderer_)) {
    exact->project(probe, x, stiffness, proxy_changed, out);
  } else if (auto* null_space = std::get_if<NullSpace>(&renderer_)) {
    null_space->project(probe, dx, stiffness, out);
  } else {
    std::get_if<Standard>(&renderer_)->project(probe, dx, stiffness, out);
  }
}

void Renderer::reset() noexcept {
  if (auto* exact = std::get_if<SubspaceExact>(&renderer_)) exact->reset();
}

}  // namespace haptic::core
