#pragma once
/// The underactuated finger exoskeleton of the paper's section VI, in the planar linkage of
/// core/METHOD.md#finger-linkage: q = (l_x actuated [m], q_B sensed [rad]), x = (q_o1 MCP, q_o2
/// PIP) [rad, flexion positive]. Hand frame: origin at the MCP axis, +x distal along the
/// metacarpal, +y dorsal. The dimensions are parameters of the scene; the defaults are
/// this project's choice, because those of the paper's device are not public.

#include <array>
#include <memory>
#include <span>
#include <string_view>

#include "haptic/core/model/kinematics.hpp"

namespace haptic::core {

struct Point2 {
  double x{0.0};
  double y{0.0};
  [[nodiscard]] bool operator==(const Point2&) const = default;
};

/// Lengths in m, angles in rad. Defaults: core/METHOD.md#finger-linkage, whose actuator's force
/// flexes both joints or extends both, at every pose of [0,80] x [0,90] deg.
struct FingerDimensions {
  double proximal_phalanx{0.045};                     ///< L1, MCP to PIP axis
  Point2 rail_origin{-0.012, -0.014};                 ///< P0
  double rail_angle{82.0 * 0.017453292519943295};     ///< gamma
  Point2 body_d{0.0275, 0.0};                         ///< d: where rod 1 meets the body link
  Point2 body_e{0.064, -0.0382};                      ///< e: where rod 2 meets the body link
  double rod1{0.010};                                 ///< h1
  double rod2{0.010};                                 ///< h2
  double slider1_lower{0.004}, slider1_upper{0.020};  ///< c1
  double slider2_lower{0.004}, slider2_upper{0.030};  ///< c2
  double l_x_lower{0.0}, l_x_upper{0.0335};           ///< of the 50 mm that the actuator has
  double q_B_lower{-50.0 * 0.017453292519943295}, q_B_upper{62.0 * 0.017453292519943295};
  [[nodiscard]] bool operator==(const FingerDimensions&) const = default;
};

/// The linkages that have a name: the default dimensions, and finger_sign_change().
inline constexpr std::array<std::string_view, 2> kFingerLinkages{"finger_same_sign",
                                                                 "finger_sign_change"};

/// The linkage of the hard studies and of most figures of core/METHOD.md: well conditioned, but
/// over a third of the workspace its actuator flexes one joint and extends the other.
[[nodiscard]] FingerDimensions finger_sign_change() noexcept;

/// The same linkage `size` times as large: every length and stroke multiplied, no angle changed.
/// The joints then follow q_B and l_x / size as before.
[[nodiscard]] FingerDimensions scaled(const FingerDimensions& dimensions, double size) noexcept;

class FingerExoskeleton final : public Kinematics {
 public:
  /// Throws SceneError naming the dimension that cannot be (a length <= 0, a lower limit above its
  /// upper one, a linkage that closes nowhere in its box).
  explicit FingerExoskeleton(const FingerDimensions& dimensions);
  ~FingerExoskeleton() override;

  [[nodiscard]] MapStatus evaluate(const VecQ& q, VecX& x_probe, MatXQ& J) const noexcept override;
  [[nodiscard]] MapStatus position(const VecQ& q, VecX& x_probe) const noexcept override;
  [[nodiscard]] InverseStatus inverse(const VecX& x, VecQ& q) const noexcept override;
  [[nodiscard]] std::span<const Mechanism> mechanisms() const noexcept override;
  [[nodiscard]] MapStatus constraints(const VecQ& q, Constraints& out) const noexcept override;
  [[nodiscard]] Drawing drawing() const override;

  /// A pose of the exoskeleton and how it moves there.
  struct Motion {
    Eigen::Vector2d q{Eigen::Vector2d::Zero()};
    Eigen::Matrix2d J{Eigen::Matrix2d::Zero()};        ///< dx/dq
    Eigen::Vector2d product{Eigen::Vector2d::Zero()};  ///< J_dot q_dot
  };
  /// inverse() of an x in reach, and in the same work J there and J_dot q_dot for the rates that
  /// move x at `x_dot`: what a simulation that follows x needs. kUnreachable: `out` is untouched.
  [[nodiscard]] InverseStatus follow(const Eigen::Vector2d& x, const Eigen::Vector2d& x_dot,
                                     Motion& out) const noexcept;
  /// J_dot q_dot: how x accelerates at constant q_dot.
  [[nodiscard]] MapStatus velocity_product(const VecQ& q, const Eigen::Vector2d& q_dot,
                                           Eigen::Vector2d& out) const noexcept;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
  Mechanism self_;
};

/// Throws SceneError as the constructor does.
[[nodiscard]] std::unique_ptr<FingerExoskeleton> make_finger_exoskeleton(
    const FingerDimensions& dimensions);

}  // namespace haptic::core
