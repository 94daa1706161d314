#pragma once
/// The energy that the rendered spring stores, V(d) with d = q*_a - q_a. V is saturated as the
/// force is (core/METHOD.md#actuator-limits, core/METHOD.md#energy-tank): so the force is its
/// gradient, and no cycle of q pumps energy.
///
/// Z_q diagonal: per actuated DoF a Huber potential, quadratic up to the force limit r, then
/// linear,
///   V_i = g K_i d_i^2 / 2                    while K_i |d_i| <= r_i
///   V_i = g (r_i |d_i| - r_i^2 / (2 K_i))    beyond;    tau_i = g clamp(K_i d_i, +-r_i).
/// Z_q coupled: the spring as a whole, by its length L = ||d||_{Z_q} = sqrt(d^T Z_q d),
///   V = g L^2 / 2             while L <= rho,    tau = g Z_q d
///   V = g (rho L - rho^2 / 2)   beyond;          tau = g Z_q d rho / L,
/// rho = min_i r_i / sqrt((Z_q)_ii): by Cauchy-Schwarz |(Z_q d)_i| <= sqrt((Z_q)_ii) L, so |tau_i|
/// <= g r_i for every i, and the clamp of each actuator that follows, which alone would pump, has
/// nothing left to cut.

#include "haptic/core/types.hpp"

namespace haptic::core {

struct SpringStorage {
  VecA stiffness{};    ///< K = diag(Z_q), n_a, >= 0; N/m or N m/rad
  VecA limit{};        ///< r, n_a, >= 0; N or N m; a coupled spring takes it in hold_within()
  double gain{0.0};    ///< g in [0, 1]
  MatAA Z_q{};         ///< n_a by n_a, symmetric, positive semidefinite; size 0: diagonal
  double radius{0.0};  ///< rho of a coupled spring, the square root of J; unused otherwise

  [[nodiscard]] bool coupled() const noexcept { return Z_q.size() > 0; }
  /// For a coupled spring: sets `limit` = r and rho from it, slightly below so that rounding lifts
  /// no component above its limit. Returns the DoF that decides rho, -1 if no stiffness is left.
  int hold_within(const VecA& r) noexcept;
  /// L of a coupled spring, the square root of J.
  [[nodiscard]] double length(const VecA& d) const noexcept;

  /// V(d), J. d: n_a, m or rad.
  [[nodiscard]] double energy(const VecA& d) const noexcept;
  /// dV/dd = the elastic force of the law, n_a.
  [[nodiscard]] VecA force(const VecA& d) const noexcept;
  /// The largest s in [0, 1] with Z_q s d no larger than force(d) at gain 1 in any component: 1
  /// unless the limit saturates it.
  [[nodiscard]] double relief(const VecA& d) const noexcept;
  /// The largest s in [0, 1] with V(s d) <= `energy` (J): exact, piecewise quadratic in s.
  [[nodiscard]] double scale_to(const VecA& d, double energy) const noexcept;

 private:
  [[nodiscard]] double coupled_scale_to(double length, double energy) const noexcept;
};

}  // namespace haptic::core
