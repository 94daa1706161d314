#include "hw/emulator/linear_actuator.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::hw::emulator {

void LinearActuator::drive(double u, bool on) noexcept {
  on_ = on && std::isfinite(u);
  u_ = on_ ? std::clamp(u, -full_drive(), full_drive()) : 0.0;
}

double LinearActuator::cell_force(double l, double l_dot) const noexcept {
  const double half = 0.5 * p_.backlash;
  const double stretch = x_ - l;
  const double pressed = stretch > half ? stretch - half : stretch < -half ? stretch + half : 0.0;
  if (pressed == 0.0) return 0.0;
  const double force = p_.cell_stiffness * pressed + p_.cell_damping * (v_ - l_dot);
  // Flanks of a gear push; the damper must not make them pull.
  return pressed > 0.0 ? std::max(0.0, force) : std::min(0.0, force);
}

void LinearActuator::step(double dt, double l, double l_dot) noexcept {
  force_ = cell_force(l, l_dot);
  const double limit = p_.max_force + p_.friction;
  const double back_emf = p_.stall_force / p_.no_load_speed;  // N s/m
  const bool pushes = on_ && !stalled_;
  // The current limit first: within it the back-EMF damps (and is taken implicitly), beyond it the
  // motor gives what the limit allows.
  const double wanted = u_ - back_emf * v_;
  const bool limited = std::abs(wanted) > limit;
  const double motor = !pushes ? 0.0 : limited ? std::copysign(limit, wanted) : u_;
  const double damping = pushes && !limited ? back_emf : 0.0;
  const double inertia = p_.mass + dt * damping;
  const double sliding = (p_.mass * v_ + dt * (motor - force_)) / inertia;
  const double stick = sliding * inertia / dt;  // the friction that would stop it, N
  v_ = sliding - dt / inertia * std::clamp(stick, -p_.friction, p_.friction);
  const double moved = x_ + dt * v_;
  x_ = std::clamp(moved, 0.0, p_.stroke);
  if (x_ != moved) v_ = 0.0;
}

}  // namespace haptic::hw::emulator
