#pragma once
/// Input and answer of a renderer (tests/report/STUDY.md#fig-4-finger_sign_change and
/// core/METHOD.md#nonlinear-projection).

#include "haptic/core/contacts/contacts.hpp"
#include "haptic/core/projection_status.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

/// The device in X at this tick. References must outlive the call only.
struct Probe {
  const VecQ& q;
  const VecX& x_probe;
  const MatXQ& J;
  ContactView contacts{};
};

struct Projection {
  VecQ q_star{};  ///< n_q; where the spring is anchored
  ProjectionStatus status{ProjectionStatus::kNone};
  double residual{0.0};   ///< ||x (-) f(q*)||_W (exact) or ||dx - J dq||_W (linearised)
  double condition{0.0};  ///< max|R_kk|/min|R_kk| of the equilibrated J; 0 if J was not used
  /// With a prior: what its springs store besides 1/2 ||q*_a - q_a||^2_{Z_q}, J: Eq. (18) less
  /// that. The sum is the potential whose negative gradient is tau_a. 0 without a prior.
  double storage{0.0};
  /// Rule per contact: force held back because one contact's push would push another in.
  bool contradicted{false};
  /// Then: where the spring would be anchored if no contact held it back, n_q.
  VecQ q_wish{};
  /// Eq. (6) beyond reach: held on a branch though another is nearer, or on its way there.
  bool between{false};
  /// Rule per contact: share of damping near a singularity, 0 (none) to 1 (at it).
  double damping{0.0};
};

}  // namespace haptic::core
