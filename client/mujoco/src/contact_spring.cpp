#include "haptic/mujoco/contact_spring.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::mujoco {

namespace {

constexpr double kLeastInverseMass = 1e-12;  // 1/kg: both bodies are part of the world

}  // namespace

ContactSpring::ContactSpring(const mjModel& model, const mjContact& contact) {
  std::copy_n(contact.solimp, mjNIMP, solimp_);
  for (int i = 0; i < 2; ++i) solimp_[i] = std::clamp<double>(solimp_[i], mjMINIMP, mjMAXIMP);
  solimp_[3] = std::clamp<double>(solimp_[3], mjMINIMP, mjMAXIMP);
  solimp_[4] = std::max(solimp_[4], 1.0);
  const double dmax = solimp_[1];
  double K = -contact.solref[0] / (dmax * dmax);
  if (contact.solref[0] > 0.0) {
    const bool safe = (model.opt.disableflags & mjDSBL_REFSAFE) == 0;
    const double time = std::max<double>(contact.solref[0], safe ? 2.0 * model.opt.timestep : 0.0);
    const double root = dmax * time * contact.solref[1];
    K = 1.0 / (root * root);
  }
  double inverse_mass = 0.0;
  for (const int geom : {contact.geom1, contact.geom2}) {
    if (geom >= 0) inverse_mass += model.body_invweight0[2 * model.geom_bodyid[geom]];
  }
  per_depth_ = K / std::max(inverse_mass, kLeastInverseMass);
  if (contact.dim > 1 && model.opt.cone == mjCONE_PYRAMIDAL) {
    const double mu = contact.friction[0], ratio = std::max<double>(model.opt.impratio, mjMINVAL);
    per_depth_ *= (contact.dim - 1) * ratio / (mu * mu * (1.0 + mu * mu));
  }
}

double ContactSpring::impedance(double depth) const {
  const double d0 = solimp_[0], dmax = solimp_[1], width = solimp_[2];
  if (d0 == dmax || width <= mjMINVAL) return 0.5 * (d0 + dmax);
  const double x = std::min(std::abs(depth) / width, 1.0);
  const double middle = solimp_[3], power = solimp_[4];
  const double y = x <= middle
                       ? std::pow(x, power) / std::pow(middle, power - 1.0)
                       : 1.0 - std::pow(1.0 - x, power) / std::pow(1.0 - middle, power - 1.0);
  return d0 + y * (dmax - d0);
}

double ContactSpring::force(double depth) const {
  if (!(depth > 0.0)) return 0.0;
  const double d = impedance(depth);
  return per_depth_ * d * d / (1.0 - d) * depth;
}

double ContactSpring::slope(double depth) const {
  const double step = 1e-4 * std::max(solimp_[2], 1e-6), at = std::max(depth, step);
  return std::max((force(at + step) - force(at - step)) / (2.0 * step), 1e-9);
}

double ContactSpring::stiffness(double depth) const {
  if (depth > 0.0) return slope(depth);
  const double half = 0.5 * std::max(solimp_[2], 1e-6);
  return force(half) / half;
}

}  // namespace haptic::mujoco
