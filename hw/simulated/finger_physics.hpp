#pragma once
/// The mechanics of a finger that wears the exoskeleton, core/METHOD.md#forces-at-the-finger: two
/// joints, moved by the user's hand, with the actuator's mass, damping, friction and force
/// reflected to them.
///
///   (I + m w w^T) x_ddot = K_h (x_des - x) - B_h x_dot + tau_stop
///                          + w (tau_a - b l_dot - F_c(l_dot) + m w^T J_dot q_dot)
///
/// with q = f^-1(x) (rigidly worn), w = (S J^-1)^T, l_dot = w^T x_dot: positive tau_a pushes
/// towards larger l_x. The last term is the actuator's share of the velocity products: without it
/// M(x) would create energy. tau_stop: one-sided spring and damper towards the nearest pose the
/// exoskeleton reaches, zero inside its reach.
///
/// Integration: semi-implicit Euler, damping, stop and friction at the new velocity, hence none of
/// them can ever give energy. Friction solves its scalar inclusion exactly (J. J. Moreau's time
/// stepping): it sticks without creeping and needs no regularisation speed.

#include <Eigen/Core>
#include <memory>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/simulated/reach_edge.hpp"

namespace haptic::hw {

struct FingerParameters {
  Eigen::Vector2d inertia{1.2e-4, 4e-5};  ///< diagonal of I, kg m^2
  double hand_stiffness{0.6};             ///< K_h, N m/rad
  double hand_damping{0.012};             ///< B_h, N m s/rad
  double actuator_mass{0.05};             ///< m, kg
  double actuator_damping{2.0};           ///< b, N s/m
  double actuator_friction{0.0};          ///< F_c, N
  /// The stop: 50 times the default hand, so that the hand's strongest press (0.6 N m/rad by 1 rad)
  /// gives way by 1 degree; damping critical for the lighter joint.
  double stop_stiffness{30.0};  ///< N m/rad
  double stop_damping{0.07};    ///< N m s/rad
};

/// Joules since the simulation began. kinetic == by_user + by_actuator - (the losses), up to the
/// integration's own loss.
struct FingerEnergy {
  double by_user{0.0};      ///< work of the hand's spring and damper on the finger
  double by_actuator{0.0};  ///< work of tau_a
  double damping{0.0};      ///< lost in the actuator's damping, never falls
  double friction{0.0};     ///< lost in its friction, never falls
  double stop{0.0};         ///< given to the end stop: stored and lost
};

/// The map as a finger's. Throws DeviceError: it is none.
[[nodiscard]] std::shared_ptr<const core::FingerExoskeleton> require_finger(
    const std::shared_ptr<const core::Kinematics>& kinematics);

class FingerPhysics {
 public:
  /// Starts at rest in `x` (rad), or the nearest pose to it in reach. Throws as require_finger().
  FingerPhysics(const FingerParameters& parameters,
                const std::shared_ptr<const core::Kinematics>& kinematics,
                const Eigen::Vector2d& x);

  /// One step of `dt` s with the force tau_a (N) and the user's aim x_des (rad).
  void step(double dt, const Eigen::Vector2d& x_des, double tau_a) noexcept;

  /// True: the hand moves the finger with K_h (so it begins). False: the hand hangs loose.
  void hold(bool held) noexcept { hand_stiffness_ = held ? p_.hand_stiffness : 0.0; }

  [[nodiscard]] const Eigen::Vector2d& x() const noexcept { return x_; }          ///< rad
  [[nodiscard]] const Eigen::Vector2d& x_dot() const noexcept { return x_dot_; }  ///< rad/s
  /// (l_x, q_B) at x, inside the box.
  [[nodiscard]] const core::VecQ& q() const noexcept { return linkage_.q; }
  /// q `ahead` s later at the present velocity; `ahead` is at most one step.
  [[nodiscard]] core::VecQ q_ahead(double ahead) const noexcept;
  [[nodiscard]] double l_dot() const noexcept { return linkage_.w.dot(x_dot_); }  ///< m/s
  /// x is in reach: no end stop pushes.
  [[nodiscard]] bool in_reach() const noexcept { return linkage_.out.isZero(0.0); }
  [[nodiscard]] double kinetic() const noexcept;  ///< J, joints and actuator
  [[nodiscard]] const FingerEnergy& energy() const noexcept { return energy_; }

 private:
  /// The exoskeleton at the finger's pose, or at the nearest to it in reach.
  struct Linkage {
    core::VecQ q{};
    Eigen::Matrix2d J{Eigen::Matrix2d::Identity()};
    double det{0.0};                                   ///< of J; its sign never changes
    Eigen::Vector2d reached{Eigen::Vector2d::Zero()};  ///< f(q), rad
    Eigen::Vector2d w{Eigen::Vector2d::Zero()};        ///< dl_x/dx, m/rad
    double pull{0.0};                                  ///< w^T J_dot q_dot, m/s^2
    Eigen::Vector2d out{Eigen::Vector2d::Zero()};      ///< from x back into reach, rad; 0 inside
  };
  void place() noexcept;
  void search() noexcept;
  void follow_edge() noexcept;
  [[nodiscard]] bool move_to(const core::VecQ& q) noexcept;
  [[nodiscard]] bool adopt(const core::FingerExoskeleton::Motion& at,
                           const Eigen::Vector2d& reached) noexcept;
  [[nodiscard]] core::VecQ boxed(core::VecQ q) const noexcept;
  [[nodiscard]] Eigen::Vector2d to_q(const Eigen::Vector2d& x_change) const noexcept;
  [[nodiscard]] double velocity_product() const noexcept;

  FingerParameters p_;
  double hand_stiffness_;  ///< N m/rad, now
  std::shared_ptr<const core::FingerExoskeleton> finger_;
  Eigen::Vector2d x_;
  Eigen::Vector2d x_dot_{Eigen::Vector2d::Zero()};
  Linkage linkage_{};
  ReachEdge edge_{};
  Eigen::Vector2d searched_at_{Eigen::Vector2d::Zero()};  ///< x of the last search
  int steps_since_search_{0};
  FingerEnergy energy_{};
};

}  // namespace haptic::hw
