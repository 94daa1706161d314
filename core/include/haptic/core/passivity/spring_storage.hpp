#pragma once
/// What the rendered spring stores, V(d) with d = q*_a - q_a, saturated as its force is (METHOD 4.5,
/// 5.3): per actuated DoF a Huber potential, quadratic up to the force limit r and linear beyond,
///   V_i = g K_i d_i^2 / 2                    while K_i |d_i| <= r_i
///   V_i = g (r_i |d_i| - r_i^2 / (2 K_i))    beyond,
/// whose gradient is the force after saturation and the envelope, g clamp(K_i d_i, +-r_i).

#include "haptic/core/types.hpp"

namespace haptic::core {

struct SpringStorage {
  VecA stiffness{};  ///< K of Z_q, n_a, >= 0; N/m or N m/rad
  VecA limit{};      ///< r, n_a, >= 0; N or N m
  double gain{0.0};  ///< g in [0, 1]

  /// V(d), J. d: n_a, m or rad.
  [[nodiscard]] double energy(const VecA& d) const noexcept;
  /// dV/dd = the elastic force of the law, n_a.
  [[nodiscard]] VecA force(const VecA& d) const noexcept;
  /// The largest s in [0, 1] with V(s d) <= `energy` (J): exact, V(s d) is piecewise quadratic in s.
  [[nodiscard]] double scale_to(const VecA& d, double energy) const noexcept;
};

}  // namespace haptic::core
