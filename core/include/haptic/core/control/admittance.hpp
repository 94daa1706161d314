#pragma once
/// Force by motion, for an actuator that takes positions: it is moved as a virtual mass and damper
/// would move under the difference between the wanted and the measured force.
///
///   m v_dot + d v = reference - measured,   x_dot = v,   |v| <= max_rate,   lower <= x <= upper
///
/// At rest measured = reference, whatever the actuator's friction and gearing. Both parts are
/// implicit in v, so that any m and d are stable by themselves. Against a surface of stiffness k
/// the loop needs d > k T roughly (T the step), and m below d^2 / (4 k) for a response without
/// overshoot.

namespace haptic::core {

struct AdmittanceParameters {
  double mass{0.0};      ///< m, kg or kg m^2, >= 0
  double damping{1.0};   ///< d, N s/m or N m s/rad, > 0
  double max_rate{1.0};  ///< m/s or rad/s, > 0: the actuator's own
  double lower{0.0};     ///< m or rad: travel, below upper
  double upper{1.0};
};

class Admittance {
 public:
  /// Throws SceneError naming the parameter that is not allowed.
  explicit Admittance(const AdmittanceParameters& parameters);

  /// Starts at rest in `position` (held within the travel): where the actuator is, so that
  /// switching on moves nothing.
  void reset(double position) noexcept;
  /// One step of `dt` s, > 0. Returns the position to command, m or rad. Never allocates or throws;
  /// a force that is not finite stops the motion.
  [[nodiscard]] double step(double reference, double measured, double dt) noexcept;

  [[nodiscard]] double position() const noexcept { return position_; }
  [[nodiscard]] double rate() const noexcept { return rate_; }  ///< v of the last step
  /// The last step was held by max_rate or an end of the travel.
  [[nodiscard]] bool limited() const noexcept { return limited_; }

 private:
  AdmittanceParameters p_;
  double position_;
  double rate_{0.0};
  bool limited_{false};
};

}  // namespace haptic::core
