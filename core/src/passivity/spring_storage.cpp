#include "haptic/core/passivity/spring_storage.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

double SpringStorage::energy(const VecA& d) const noexcept {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const double K = stiffness[i], r = limit[i], stretch = std::abs(d[i]);
    if (K == 0.0) continue;
    sum += K * stretch <= r ? 0.5 * K * stretch * stretch : r * (stretch - 0.5 * r / K);
  }
  return gain * sum;
}

VecA SpringStorage::force(const VecA& d) const noexcept {
  VecA tau(d.size());
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    tau[i] = gain * std::clamp(stiffness[i] * d[i], -limit[i], limit[i]);
  }
  return tau;
}

double SpringStorage::scale_to(const VecA& d, double energy_wanted) const noexcept {
  if (this->energy(d) <= energy_wanted) return 1.0;
  if (!(energy_wanted > 0.0)) return 0.0;
  // The last corner of V(s d), a DoF entering saturation, that still lies within the energy.
  double corner = 0.0;
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const double unlimited = stiffness[i] * std::abs(d[i]);
    if (!(unlimited > limit[i])) continue;
    const double s = limit[i] / unlimited;
    if (s > corner && this->energy(VecA(s * d)) <= energy_wanted) corner = s;
  }
  // From there V(s d) = a s^2 + b s - c up to the next corner, which already exceeds the energy.
  double a = 0.0, b = 0.0, c = 0.0;
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const double K = stiffness[i], r = limit[i], stretch = std::abs(d[i]);
    if (K == 0.0) continue;
    if (K * stretch > r && r / (K * stretch) <= corner) {
      b += gain * r * stretch;
      c += gain * 0.5 * r * r / K;
    } else {
      a += gain * 0.5 * K * stretch * stretch;
    }
  }
  const double level = energy_wanted + c;
  const double s = 2.0 * level / (b + std::sqrt(b * b + 4.0 * a * level));
  return std::clamp(s, 0.0, 1.0);
}

}  // namespace haptic::core
