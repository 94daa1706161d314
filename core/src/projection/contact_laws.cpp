#include "haptic/core/projection/contact_laws.hpp"

#include <cmath>

namespace haptic::core {

void ContactLaws::take(const PlaneSet::Laws& told, int i, double velocity, double length) noexcept {
  if (told.cols() == 0 || !(told(PlaneSet::kMass, i) > 0.0)) return;
  const double area = length * length;
  with_ |= 1u << i;
  mass_[i] = told(PlaneSet::kMass, i) * area;
  damping_[i] = told(PlaneSet::kDamping, i) * area;
  stiffness_[i] = told(PlaneSet::kStiffness, i) * area;
  load_[i] = told(PlaneSet::kLoad, i) * length;
  v_[i] = velocity / length;
  s_[i] = l_[i] = free_[i] = give_[i] = 0.0;
  dt_ = 0.0;
}

/// M (v' - v) / T = (l + l') / 2 + load - D (s' - s) / T - k (s + s') / 2, s' - s = T (v + v') / 2.
bool ContactLaws::begin(double dt) noexcept {
  const bool changed = dt != dt_;
  dt_ = dt;
  for (int i = 0; i < kMaxPlanes; ++i) {
    if (!has(i)) continue;
    if (!(dt > 0.0)) {
      free_[i] = s_[i];
      give_[i] = 0.0;
      continue;
    }
    const double inertia = 2.0 * mass_[i] / (dt * dt);
    give_[i] = 0.5 / (inertia + damping_[i] / dt + 0.5 * stiffness_[i]);
    const double push = inertia * dt * v_[i] - stiffness_[i] * s_[i] + 0.5 * l_[i] + load_[i];
    free_[i] = s_[i] + 2.0 * give_[i] * push;
  }
  return changed;
}

void ContactLaws::end(int i, double l) noexcept {
  if (!has(i)) return;
  const double s = free_[i] + give_[i] * l;
  if (dt_ > 0.0) v_[i] = 2.0 * (s - s_[i]) / dt_ - v_[i];
  s_[i] = s;
  l_[i] = l;
}

double ContactLaws::energy() const noexcept {
  double twice = 0.0;
  for (int i = 0; i < kMaxPlanes; ++i) {
    if (!has(i)) continue;
    twice += mass_[i] * v_[i] * v_[i];
    const double held = load_[i] - stiffness_[i] * s_[i];
    if (stiffness_[i] > 0.0) twice += held * held / stiffness_[i];
  }
  return 0.5 * twice;
}

}  // namespace haptic::core
