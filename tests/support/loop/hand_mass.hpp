#pragma once
/// The one-DoF experiment of core/METHOD.md#local-models: a mass with viscous damping, moved by a
/// hand through a spring and a damper. Damping of the device is implicit, hence never gives energy.

#include <algorithm>

namespace haptic::test {

class HandMass {
 public:
  static constexpr double kMass = 0.15;            ///< kg
  static constexpr double kDamping = 1.0;          ///< of the device, N s/m
  static constexpr double kHandStiffness = 300.0;  ///< N/m
  static constexpr double kHandDamping = 2.0;      ///< N s/m
  static constexpr double kReach = 0.19;           ///< m, inelastic ends of the device

  explicit HandMass(double q) : q_(q) {}

  /// One step of `dt` s with the force tau (N), the hand aiming at `aim` (m) that moves at
  /// `aim_dot`.
  void step(double dt, double tau, double aim, double aim_dot) noexcept {
    const double push = kHandStiffness * (aim - q_) + kHandDamping * (aim_dot - v_) + tau;
    v_ = (v_ + dt * push / kMass) / (1.0 + dt * kDamping / kMass);
    q_ += dt * v_;
    if (q_ < -kReach || q_ > kReach) v_ = 0.0;
    q_ = std::clamp(q_, -kReach, kReach);
  }
  [[nodiscard]] double q() const noexcept { return q_; }  ///< m
  [[nodiscard]] double v() const noexcept { return v_; }  ///< m/s

 private:
  double q_;
  double v_{0.0};
};

}  // namespace haptic::test
