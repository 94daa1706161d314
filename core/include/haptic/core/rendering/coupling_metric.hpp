#pragma once
/// A metric on X for a client's own projection, x = argmin ||x - f(q)||_W over what its scene
/// allows (core/METHOD.md#anisotropic-coupling): stiff where the device can render it, soft where
/// it cannot. Made of the device's pose, not for the tick: it allocates.
///
/// With A = W_x^{1/2} J of full column rank, A^+ = (A^T A)^{-1} A^T and dx weighed alike,
///   ||dx||_W^2 = dq_a^T Z_q dq_a + eps k_x sum_i ||A_i||^2 dq_n,i^2 + eps k_x ||dx - A dq||^2,
///   dq = A^+ dx,   k_x = mean over the actuated DoFs j of Z_q,j / ||A_j||^2.
/// It is an energy, twice what springs in Q would store, J: on an actuated DoF its own Z_q; on a
/// sensed one eps times the spring that an actuator would need which moves the probe as far per
/// unit; and eps times the same spring on what no q reaches, without which W would not be definite.
/// No choice of units of q or x changes ||dx||_W. eps = 1: a device with actuators all over; eps ->
/// 0: first as near as possible in the actuated directions, then in the rest.
///
/// What a client gains or loses by it is a figure of the study, `haptic-report coupling`; a proxy
/// found with it is not conservative in the loop, and wants direction guard and energy tank as any
/// other.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "haptic/core/rendering/projection_model.hpp"

namespace haptic::core {

/// W at q, n_x by n_x, symmetric positive definite, in J per product of the units of two
/// coordinates. W_x: for the n_x of `map`. stiffness: diag(Z_q), n_a; `coupling`: of Z_q, null
/// where it is diagonal. softness: eps, 0 < eps <= 1. Empty where f has no value at q, J has not
/// full column rank, a stiffness is not above 0, or W is not finite.
[[nodiscard]] std::optional<Eigen::MatrixXd> coupling_metric(
    const Kinematics& map, const TaskMetric& W_x, const VecQ& q, const VecA& stiffness,
    double softness, const StiffnessCoupling* coupling = nullptr);

/// W of consecutive coordinates of x, which weighs nothing outside of them.
struct CouplingBlock {
  int coordinates{0};
  /// W_00, W_10, W_11, W_20, ...: the lower triangle row by row. Empty where there is none (above).
  std::vector<double> lower{};
};

/// The same for every independent block of the model's map, in the order of x; one block where the
/// map has none or W_x ties them together.
[[nodiscard]] std::vector<CouplingBlock> coupling_blocks(const ProjectionModel& model,
                                                         const VecQ& q, const VecA& stiffness,
                                                         double softness);

}  // namespace haptic::core
