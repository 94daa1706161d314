#pragma once
/// A finger in the exoskeleton that presses on a plane in joint space, at rest
/// (core/METHOD.md#anisotropic-coupling): what an underactuated device makes of a proxy, against
/// one that drives both DoFs.

#include <Eigen/Core>
#include <optional>

#include "haptic/core/model/kinematics.hpp"

namespace haptic::report {

/// The user means to be `penetration` beyond the plane through `pose`, straight along its normal.
struct Press {
  Eigen::Vector2d pose{};    ///< MCP, PIP; on the plane, rad
  Eigen::Vector2d normal{};  ///< of length 1, outwards: n.x <= n.pose is free
  double penetration{0.0};   ///< rad
  double stiffness{0.0};     ///< Z_q of the actuator, N/m
};

/// The user's own spring, core/METHOD.md#forces-at-the-finger; N m/rad.
inline constexpr double kHandStiffness = 0.6;

struct Rest {
  double tau_a{0.0};        ///< of the actuator, N; positive towards larger l_x
  double penetration{0.0};  ///< of the probe, rad; as `Press::penetration` where nothing is felt
};

/// Springs of K = Z_q / ||J_a||^2 on both joints, J_a of the pose, which a device with an actuator
/// on both DoFs renders exactly; tau_a is the part of it that acts on the first: J_a^T K (x -
/// x_probe).
[[nodiscard]] std::optional<Rest> full_device(const core::Kinematics& finger, const Press& press);

/// tau_a = Z_q S J^{-1} (x - x_probe), Eq. (8), on one DoF, the other not held back; the proxy is
/// the client's x = argmin ||x - x_probe||_W on the free side, W the coupling metric of that
/// softness at the pose in question, or the identity without one. The rest that the finger comes to
/// from the pose; empty where it leaves the workspace.
[[nodiscard]] std::optional<Rest> underactuated(const core::Kinematics& finger, const Press& press,
                                                std::optional<double> softness);

}  // namespace haptic::report
