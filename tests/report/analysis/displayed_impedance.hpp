#pragma once
/// The displayed impedance d tau_a/dq of the four renderers (paper, sections IV and V): by the
/// paper's formulas, which hold the proxy and J still, and exactly, with dJ/dq and, where the proxy
/// moves with the device, dx/dq (core/METHOD.md#exact-derivatives). For reports, diagnostics and
/// tests, not for the tick.
///
/// The rows of d tau/dq that belong to sensed DoFs are zero (tau = S^T tau_a) and are left out:
/// results are n_a by n_q, columns in the order of q. A force that opposes motion has a negative
/// d tau_a/dq_a.

#include <memory>
#include <optional>

#include "haptic/core/linear/stiffness_coupling.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/rendering/renderer_kind.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

using MatAQ = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxQ, kMaxQ>;
using MatAX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxQ, kMaxX>;
using MatXX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxX, kMaxX>;

/// The two stiffnesses a comparison needs: that of the subspace methods and that of the baselines.
struct RenderingImpedance {
  VecA Z_q{};   ///< n_a, its diagonal; N/m or N m/rad. Eq. (6), (8)
  MatXX Z_x{};  ///< n_x by n_x, symmetric; force per unit of x. Eq. (1), (4)
  std::shared_ptr<const StiffnessCoupling> coupling{};  ///< of Z_q; null: it is diagonal

  /// Z_q whole, n_a by n_a.
  [[nodiscard]] MatAA actuated() const noexcept;
};

/// Eq. (2) standard, Eq. (5) null-space, Eq. (9) both subspace methods: J constant, x held.
/// Empty where f has no value at q, or the null-space method's J_n lacks full column rank.
[[nodiscard]] std::optional<MatAQ> theoretical_impedance(RendererKind kind,
                                                         const Kinematics& kinematics,
                                                         const VecQ& q,
                                                         const RenderingImpedance& impedance);

/// The exact d tau_a/dq at q with the proxy held at x (core/METHOD.md#exact-derivatives). Empty as
/// above, and where Eq. (8) needs J of full column rank and has it not. Eq. (6): -Z_q S, whatever J
/// is, for q* does not depend on q.
[[nodiscard]] std::optional<MatAQ> exact_impedance(RendererKind kind, const Kinematics& kinematics,
                                                   const VecQ& q, const VecX& x,
                                                   const RenderingImpedance& impedance);

/// d tau_a/dx (n_a by n_x) at fixed q. Where the proxy moves with the device, the whole derivative
/// is exact_impedance() + proxy_gain() * dx/dq. Eq. (6) takes G = (J*^T J* - sum_i r_i H_i)^{-1}
/// J*^T at q_star, the curvature included; coordinates of q_star on their box do not move. Empty as
/// above, and where q_star is held by a limit that is not its box (a slider's), or is no minimum.
[[nodiscard]] std::optional<MatAX> proxy_gain(RendererKind kind, const Kinematics& kinematics,
                                              const VecQ& q, const VecX& x, const VecQ& q_star,
                                              const RenderingImpedance& impedance);

}  // namespace haptic::core
