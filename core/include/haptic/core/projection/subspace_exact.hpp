#pragma once
/// Eq. (6): q* = argmin ||x (-) f(q*)||_W^2 over the box of q* and the mechanisms' own limits (
/// core/METHOD.md#projection-algorithm).
///
/// Case A, no prior: q* depends on x alone, so it is solved once per change of the proxy and held
/// in between: two flops per DoF remain for every other tick, and no cycle of q can pump energy. If
/// the map has a closed form it is used: exact within reach, and beyond it the map's own nearest
/// pose, which minimises the unweighted distance; if W is not a multiple of the identity the
/// iteration goes on from there. Without a closed form q* is iterated.
/// Case B, with a prior: its actuated part follows the device, so every tick iterates, from the
/// last q*; q_n^ref is taken when the proxy changes.

#include "haptic/core/projection/prior_target.hpp"
#include "haptic/core/projection/projection.hpp"
#include "haptic/core/projection/projection_model.hpp"
#include "haptic/core/projection/proxy_solver.hpp"

namespace haptic::core {

class SubspaceExact {
 public:
  explicit SubspaceExact(const ProjectionModel& model);
  /// As Renderer::project.
  void project(const Probe& probe, const VecX& x, const VecX& dx, const VecA& stiffness,
               bool proxy_changed, Projection& out) noexcept;
  /// Forgets q* and q_n^ref.
  void reset() noexcept;

 private:
  [[nodiscard]] VecQ seed_near(const VecQ& q) const noexcept;
  void solve(const Probe& probe, const VecX& x, const VecA& stiffness) noexcept;
  void solve_with_prior(const Probe& probe, const VecX& x, const VecA& stiffness,
                        bool proxy_changed) noexcept;

  ProjectionModel model_;
  ProxySolver solver_;
  PriorTarget target_;
  bool has_solution_{false};
  Projection solution_{};
  VecX x_at_{}, r_{};
  MatXQ J_{};
  bool uniform_;  ///< W is a multiple of the identity
};

}  // namespace haptic::core
