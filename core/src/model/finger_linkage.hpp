#pragma once
/// The planar linkage of core/METHOD.md#finger-linkage as plain arithmetic: forward map, Eq.
/// (10), its derivatives, Eq. (11), and its inverse in closed form, Eq. (12). Names are those of
/// the equations. Private to the finger's map.

#include <complex>

#include "haptic/core/model/finger_exoskeleton.hpp"

namespace haptic::core {

/// One assembled pose with its first derivatives; index 0 is l, 1 is t = q_B.
struct LinkagePose {
  double q1{0.0}, q2{0.0};  ///< MCP, PIP, rad
  double c1{0.0}, c2{0.0};  ///< sliders, m
  double q1_k[2]{}, phi_k[2]{};
  double c1_k[2]{}, c2_k[2]{};

  [[nodiscard]] double J(int row, int k) const noexcept {
    return row == 0 ? q1_k[k] : phi_k[k] - q1_k[k];
  }
  [[nodiscard]] double det() const noexcept { return J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0); }
};

/// Answer of the closed inverse.
struct ClosedPose {
  double l{0.0}, t{0.0};    ///< m, rad
  double c1{0.0}, c2{0.0};  ///< m
};

class FingerLinkage {
 public:
  /// A rod this close over its joint has no usable Jacobian: the linkage counts as not closing.
  static constexpr double kSmallestSlider = 1e-4;  // m
  /// m, rad: rounding at a limit is not a violation.
  static constexpr double kLimitSlack = 1e-12;

  explicit FingerLinkage(const FingerDimensions& dimensions);

  /// MCP and PIP angle alone, rad: the same to the bit as pose() gives them.
  [[nodiscard]] bool joints(double l, double t, double& q1, double& q2) const noexcept;
  [[nodiscard]] bool pose(double l, double t, LinkagePose& out) const noexcept;
  /// H[i][k][m] = d2 x_i / dq_k dq_m.
  [[nodiscard]] bool hessian(double l, double t, double (&H)[2][2][2]) const noexcept;
  /// How q1 and q2 accelerate, rad/s^2, while l and t change at the constant rates l_dot (m/s) and
  /// t_dot (rad/s).
  [[nodiscard]] bool velocity_product(double l, double t, double l_dot, double t_dot,
                                      Eigen::Vector2d& out) const noexcept;
  /// The candidate of core/METHOD.md#inverse-map on the branch det J > 0, with its sliders; not
  /// checked against any limit. With c1 > 0 and c2 > 0 it is the pose the linkage assembles to: det
  /// J = s/(c1 c2).
  [[nodiscard]] bool closed_inverse(double q1, double q2, ClosedPose& out) const noexcept;
  /// closed_inverse() of x, and in `motion` J and product for the rates x_dot of the joints, rad/s:
  /// without assembling it again. False also where its Jacobian is not usable.
  [[nodiscard]] bool closed_motion(const Eigen::Vector2d& x, const Eigen::Vector2d& x_dot,
                                   ClosedPose& out,
                                   FingerExoskeleton::Motion& motion) const noexcept;

  [[nodiscard]] const FingerDimensions& dimensions() const noexcept { return dim_; }

 private:
  FingerDimensions dim_;
  std::complex<double> P0_, e_a_, d_, e_;
};

}  // namespace haptic::core
