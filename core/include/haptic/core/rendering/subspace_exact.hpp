#pragma once
/// Eq. (6): q* = argmin ||x (-) f(q*)||_W^2 over the box of q* and the mechanisms' own limits (
/// core/METHOD.md#projection-algorithm).
///
/// Case A, no prior: q* depends on x alone, so it is solved once per change of the proxy and held
/// in between: two flops per DoF remain for every other tick, and no cycle of q can pump energy. If
/// the map has a closed form it is used: exact within reach, and beyond it the map's own nearest
/// pose, which minimises the unweighted distance; if W is not a multiple of the identity the
/// iteration goes on from there. Without a closed form q* is iterated.
/// Beyond reach two poses far apart may be equally near. q* then stays on its branch until the
/// other one is nearer by 1 % of the residual, and goes over in steps of 0.1 % of the box per tick
/// (Projection::between).
/// Case B, with a prior: its actuated part follows the device, so every tick iterates, from the
/// last q*; q_n^ref is taken when the proxy changes.

#include "haptic/core/rendering/prior_target.hpp"
#include "haptic/core/rendering/projection.hpp"
#include "haptic/core/rendering/projection_model.hpp"
#include "haptic/core/rendering/proxy_solver.hpp"

namespace haptic::core {

class SubspaceExact {
 public:
  explicit SubspaceExact(const ProjectionModel& model);
  /// See Renderer::project.
  void project(const Probe& probe, const VecX& x, const VecX& dx, const VecA& stiffness,
               bool proxy_changed, Projection& out) noexcept;
  /// Forgets q* and q_n^ref.
  void reset() noexcept;
  /// A contact ended: the next one begins on the nearest branch.
  void release() noexcept;

 private:
  [[nodiscard]] VecQ seed_near(const VecQ& q) const noexcept;
  void solve(const Probe& probe, const VecX& x, const VecA& stiffness) noexcept;
  /// After solve(): stays on the branch of the solution before, or begins to leave it.
  void choose_branch(const VecX& x, const VecA& stiffness) noexcept;
  /// One tick on the way from one branch to the other.
  void go_over() noexcept;
  /// Largest part of the box of q between a and b.
  [[nodiscard]] double apart(const VecQ& a, const VecQ& b) const noexcept;
  void solve_with_prior(const Probe& probe, const VecX& x, const VecA& stiffness,
                        bool proxy_changed) noexcept;

  ProjectionModel model_;
  ProxySolver solver_;
  PriorTarget target_;
  bool has_solution_{false};
  bool on_branch_{false};   ///< branch_ is of this contact, beyond reach
  bool going_over_{false};  ///< from one branch to branch_
  Projection solution_{};
  Projection local_{};  ///< the optimum of the former branch
  VecQ branch_{};       ///< the optimum of the branch that was chosen; solution_ may be on its way
  VecX x_before_{};     ///< whose solution branch_ is
  VecQ box_{};          ///< 1 / width of the box, 0 if there is none
  VecX x_at_{}, r_{};
  MatXQ J_{};
  bool uniform_;  ///< W is a multiple of the identity
};

}  // namespace haptic::core
