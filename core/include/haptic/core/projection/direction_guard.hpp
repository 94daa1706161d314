#pragma once
/// The direction guard (METHOD 2.4): the elastic force must not point away from the proxy as the
/// finger feels it, tau_a^T (S J^+ dx) >= 0; otherwise it is withheld for the tick.

#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/projection/projection.hpp"

namespace haptic::core {

class DirectionGuard {
 public:
  /// `kinematics` must outlive the guard.
  explicit DirectionGuard(const Kinematics& kinematics);
  /// True where tau_a (n_a) points towards the proxy, or dx = 0. One linearised solve.
  [[nodiscard]] bool allows(const Probe& probe, const VecX& dx, const VecA& tau_a) noexcept;

 private:
  const Kinematics* kinematics_;
  LeastSquares solver_;
};

}  // namespace haptic::core
