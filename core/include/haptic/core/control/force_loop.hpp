#pragma once
/// Closed loop on the measured force of one actuator. The commanded force tau_a is its reference,
/// as on the paper's device (section VI: "tau_a is used as reference force for a closed loop force
/// control"), whose load cell sits between actuator and linkage.
///
///   e = reference - measured
///   u = reference + K_P e + I + F_c clamp(e / band, -1, 1),   I_dot = K_I e
///
/// u is the drive's force in N (or N m), before friction. The last term feeds the drive's own
/// Coulomb friction forward in the direction in which it must move to reduce e; within the band it
/// is linear, so that noise of the load cell does not become chatter.
///
/// Anti-windup by conditional integration: while u is held at its limit, I does not grow further in
/// that direction. After a saturation of any length u leaves the limit as soon as K_P e and the
/// friction term allow, not after the integral has been worked off.

#include <limits>

namespace haptic::core {

struct ForceLoopGains {
  double proportional{0.0};   ///< K_P, >= 0
  double integral{0.0};       ///< K_I, 1/s, >= 0
  double friction{0.0};       ///< F_c, N or N m, >= 0; below the drive's real one, or it overshoots
  double friction_band{1.0};  ///< N or N m, > 0: the error at which friction is fed forward in full
  double output_limit{1.0};   ///< N or N m, > 0
};

/// Bounds of the drive u in one step, N or N m, each >= 0. The limits of a session hold for the
/// drive as they do for the rendered force (core/METHOD.md#limits-of-the-drive).
struct DriveBounds {
  double force{std::numeric_limits<double>::infinity()};   ///< |u|
  double change{std::numeric_limits<double>::infinity()};  ///< |u - u of the last step|
  /// `change` may hold |u| above what the loop asks for by no more than this: a force that ends
  /// ends in time, however small `change` is.
  double excess{std::numeric_limits<double>::infinity()};
};

class ForceLoop {
 public:
  /// Throws SceneError naming the gain that is not allowed.
  explicit ForceLoop(const ForceLoopGains& gains);

  /// One step of `dt` s, > 0. Returns u, |u| <= output_limit. Never allocates or throws; a
  /// measurement that is not finite gives u = 0 and leaves the integral alone.
  [[nodiscard]] double step(double reference, double measured, double dt,
                            const DriveBounds& bounds = {}) noexcept;
  /// Forgets the integral: what was measured so far no longer counts.
  void forget() noexcept { integral_ = 0.0; }
  /// The drive was off: forgets the integral, and u.
  void reset() noexcept;

  [[nodiscard]] double integral() const noexcept { return integral_; }  ///< I, N or N m
  /// u of the last step was held at the limit, or its integral because of it.
  [[nodiscard]] bool saturated() const noexcept { return saturated_; }
  /// u of the last step was held by DriveBounds::change.
  [[nodiscard]] bool slewed() const noexcept { return slewed_; }

 private:
  [[nodiscard]] double held(double wanted, double limit, const DriveBounds& bounds) const noexcept;

  ForceLoopGains gains_;
  double integral_{0.0};
  double last_{0.0};  ///< u of the last step
  bool saturated_{false};
  bool slewed_{false};
};

}  // namespace haptic::core
