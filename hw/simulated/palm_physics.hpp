#pragma once
/// The mechanics of a palm at the end of the user's arm, core/METHOD.md#forces-at-the-finger: a
/// rigid body that the arm's spring and damper move towards the pose that the user intends.
///
///   m v_dot     = K (p_des - p) + B (v_des - v)
///   I omega_dot = K_r phi + B_r (omega_des - omega),   phi: rotation vector from its orientation
///                                                      to the intended one, in the world
///
/// Integration: Euler, linearly implicit, so any stiffness is stable and no damper gives energy.
/// The ends of the position's box are rigid and inelastic.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace haptic::hw {

struct ArmParameters {
  double mass{1.0};                ///< m, kg: hand, exoskeleton, a share of the forearm
  double inertia{3e-3};            ///< I, kg m^2, about every axis
  double stiffness{500.0};         ///< K, N/m
  double damping{30.0};            ///< B, N s/m
  double rotation_stiffness{5.0};  ///< K_r, N m/rad
  double rotation_damping{0.15};   ///< B_r, N m s/rad
};

/// A pose in the world.
struct PalmPose {
  Eigen::Vector3d position{Eigen::Vector3d::Zero()};  ///< m
  Eigen::Vector3d rotation{Eigen::Vector3d::Zero()};  ///< rotation vector, rad, of any length
};

class PalmPhysics {
 public:
  /// Starts at rest in `pose`, which the box (m, of every axis) holds.
  PalmPhysics(const ArmParameters& parameters, const PalmPose& pose, double lower, double upper);

  /// One step of `dt` s towards `intended`.
  void step(double dt, const PalmPose& intended) noexcept;

  /// `ahead` s later at the present velocity, inside the box; the rotation vector is the shortest.
  [[nodiscard]] PalmPose ahead(double ahead) const noexcept;
  [[nodiscard]] const Eigen::Vector3d& velocity() const noexcept { return v_; }  ///< m/s
  [[nodiscard]] double kinetic() const noexcept;                                 ///< J
  /// Work of the arm on the palm, J. kinetic() is this, less what the ends of the box took.
  [[nodiscard]] double by_arm() const noexcept { return by_arm_; }

 private:
  ArmParameters p_;
  Eigen::Vector3d position_;
  Eigen::Quaterniond orientation_;
  Eigen::Vector3d v_{Eigen::Vector3d::Zero()};      ///< m/s
  Eigen::Vector3d omega_{Eigen::Vector3d::Zero()};  ///< rad/s, world frame
  Eigen::Vector3d intended_position_;               ///< of the step before
  Eigen::Quaterniond intended_orientation_;
  double lower_, upper_;
  double by_arm_{0.0};
};

}  // namespace haptic::hw
