#pragma once
/// A geared DC linear actuator, the paper's Firgelli (now Actuonix) L16, behind a load cell.
///
///   m v_dot = F_motor - F_cell - friction,   F_motor = clamp(u - D v, +- limit of the current)
///   F_cell  = spring and damper on the part of x - l that exceeds the backlash, pushing l along
///
/// u is the drive (PWM duty) in N of output force at standstill before friction. Switched off, the
/// motor coasts: F_motor = 0, and friction alone holds, which is why it cannot be moved by hand.
/// Source: Actuonix L16 data sheet (gearing table, back-drive force, backlash 0.25 mm); moving mass
/// and the stiffness of cell and mount are chosen. Integration: semi-implicit, friction as a scalar
/// inclusion (it sticks without creeping), so that it never gives energy.

namespace haptic::hw::emulator {

/// An L16 with the gearing 35:1.
struct ActuatorParameters {
  double no_load_speed{0.032};  ///< m/s at full drive
  double stall_force{100.0};    ///< N at full drive, net of friction: peak power is at half of each
  double friction{31.0};        ///< N, Coulomb: the back-drive force
  double max_force{50.0};       ///< N "lifted": the current limit stands there
  double mass{2.0};             ///< kg, rotor and gears seen at the rod
  double stroke{0.050};         ///< m
  double backlash{0.00025};     ///< m, in all
  double cell_stiffness{5e4};   ///< N/m, load cell and mount
  double cell_damping{40.0};    ///< N s/m
};

class LinearActuator {
 public:
  /// At rest at `x`, without force in the cell when the linkage is at the same place.
  LinearActuator(const ActuatorParameters& parameters, double x) noexcept : p_(parameters), x_(x) {}

  /// Sets the drive: u in N; switched off while `on` is false.
  void drive(double u, bool on) noexcept;
  /// The motor gives no force (a broken wire); friction stays.
  void stall(bool stalled) noexcept { stalled_ = stalled; }
  /// One step of `dt` s against a linkage at l (m) that moves with l_dot (m/s).
  void step(double dt, double l, double l_dot) noexcept;

  [[nodiscard]] double x() const noexcept { return x_; }  ///< m, what its potentiometer sees
  [[nodiscard]] double v() const noexcept { return v_; }  ///< m/s
  [[nodiscard]] double force() const noexcept { return force_; }  ///< N on the linkage, in the cell
  /// The largest |u| that has an effect, N.
  [[nodiscard]] double full_drive() const noexcept { return p_.stall_force + p_.friction; }

 private:
  [[nodiscard]] double cell_force(double l, double l_dot) const noexcept;

  ActuatorParameters p_;
  double x_;
  double v_{0.0};
  double u_{0.0};
  bool on_{false};
  bool stalled_{false};
  double force_{0.0};
};

}  // namespace haptic::hw::emulator
