#include "haptic/core/passivity/spring_storage.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic::core {

namespace {

/// Share of rho by which n_a products and a root may round, with room to spare.
constexpr double kHair = 1e-13;

}  // namespace

int SpringStorage::hold_within(const VecA& r) noexcept {
  limit = r;
  radius = std::numeric_limits<double>::infinity();
  int least = -1;
  for (Eigen::Index i = 0; i < r.size(); ++i) {
    if (!(Z_q(i, i) > 0.0)) continue;  // no force there
    const double own = r[i] / std::sqrt(Z_q(i, i));
    if (own < radius) {
      radius = own;
      least = static_cast<int>(i);
    }
  }
  radius *= 1.0 - kHair;
  return least;
}

double SpringStorage::length(const VecA& d) const noexcept {
  return std::sqrt(std::max(0.0, d.dot(Z_q.lazyProduct(d))));  // of no stiffness it rounds to < 0
}

double SpringStorage::energy(const VecA& d) const noexcept {
  if (coupled()) {
    const double L = length(d);
    return gain * (L <= radius ? 0.5 * L * L : radius * (L - 0.5 * radius));
  }
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
  if (coupled()) {
    tau = Z_q.lazyProduct(d);
    const double L = std::sqrt(std::max(0.0, d.dot(tau)));
    return tau *= L > radius ? gain * (radius / L) : gain;
  }
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    tau[i] = gain * std::clamp(stiffness[i] * d[i], -limit[i], limit[i]);
  }
  return tau;
}

double SpringStorage::relief(const VecA& d) const noexcept {
  if (coupled()) return std::min(1.0, radius / std::max(length(d), radius));
  double s = 1.0;
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const double unlimited = stiffness[i] * std::abs(d[i]);
    if (unlimited > limit[i]) s = std::min(s, limit[i] / unlimited);
  }
  return s;
}

double SpringStorage::scale_to(const VecA& d, double energy_wanted) const noexcept {
  if (this->energy(d) <= energy_wanted) return 1.0;
  if (!(energy_wanted > 0.0)) return 0.0;
  if (coupled()) return coupled_scale_to(length(d), energy_wanted);
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

/// V(s d) rises with s: s^2 L^2 / 2 up to rho, then linearly. L > 0, for V(d) > energy > 0.
double SpringStorage::coupled_scale_to(double length, double energy) const noexcept {
  const double level = energy / gain, corner = 0.5 * radius * radius;
  const double s =
      level <= corner ? std::sqrt(2.0 * level) / length : (level + corner) / (radius * length);
  return std::clamp(s, 0.0, 1.0);
}

}  // namespace haptic::core
