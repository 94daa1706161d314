#pragma once
/// How far the proxy may be from the probe before a renderer's exact displayed impedance stops
/// being negative definite on the actuated DoFs (core/METHOD.md#exact-derivatives). Necessary, not
/// sufficient for passivity: Eq. (8) keeps within it on trajectory A
/// (tests/report/STUDY.md#fig-4-finger_sign_change) and still gives energy per cycle.

#include <optional>

#include "tests/report/analysis/displayed_impedance.hpp"

namespace haptic::core {

struct PassivityCertificate {
  /// The force opposes motion of the actuated DoFs for every dx with ||dx|| < radius, in the norm
  /// of X. For one actuated DoF the bound is sharp: some dx of that length meets it. Infinite for
  /// Eq. (6). 0 where it does not oppose motion even at dx = 0.
  double radius{0.0};
  /// For the dx at hand: smallest eigenvalue of the symmetric part of -d tau_a/dq_a relative to
  /// that at dx = 0. 1 + g.dx for one actuated DoF and Eq. (8); passive where > 0.
  double margin{0.0};
};

/// At pose q with the proxy at x. Empty where exact_impedance() is. The impedance of Eq. (1), (4)
/// and (8) is affine in dx, L_0 + sum_j dx_j L_j, so n_x + 1 evaluations give it whole; the radius
/// follows from the norm of the L_j in the metric of L_0, which no choice of units of q changes.
[[nodiscard]] std::optional<PassivityCertificate> passivity_certificate(
    RendererKind kind, const Kinematics& kinematics, const VecQ& q, const VecX& x,
    const RenderingImpedance& impedance);

}  // namespace haptic::core
