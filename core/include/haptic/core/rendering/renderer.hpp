#pragma once
/// The renderers behind one call: a closed set, so a variant, not an interface.

#include <variant>

#include "haptic/core/rendering/baselines.hpp"
#include "haptic/core/rendering/per_contact.hpp"
#include "haptic/core/rendering/projection.hpp"
#include "haptic/core/rendering/renderer_kind.hpp"
#include "haptic/core/rendering/subspace_exact.hpp"
#include "haptic/core/rendering/subspace_linear.hpp"

namespace haptic::core {

class Renderer {
 public:
  /// The model is copied; its kinematics must outlive the renderer. If only a map
  /// is given, the model has neither metric nor prior.
  Renderer(RendererKind kind, const ProjectionModel& model);

  [[nodiscard]] RendererKind kind() const noexcept { return kind_; }
  /// Writes the subspace proxy for proxy `x` with dx = x (-) x_probe. Never allocates, locks,
  /// throws. `stiffness` is the actuated stiffness Z_q (n_a, diagonal); the baselines Eq. (1), (4)
  /// answer with the equivalent anchor S q* = q_a + Z_q^{-1} tau_a, so that tau_a = Z_q S(q* - q)
  /// for all. `proxy_changed` false promises that x is the one of the previous call.
  void project(const Probe& probe, const VecX& x, const VecX& dx, const VecA& stiffness,
               bool proxy_changed, Projection& out) noexcept;
  /// See BlockRenderer::widen; after a project().
  [[nodiscard]] bool widen(const Probe& probe, const VecA& stiffness, const ProxyError& error,
                           VecA& force) noexcept;
  /// A contact ended.
  void release() noexcept;
  /// Forgets warm starts, cached solutions and q_n^ref.
  void reset() noexcept;

 private:
  RendererKind kind_;
  std::variant<Baseline, SubspaceLinear, SubspaceExact, PerContact> renderer_;
};

}  // namespace haptic::core
