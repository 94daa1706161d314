#include "hw/simulated/finger_physics.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace haptic::hw {
namespace {

Eigen::Matrix2d fixed(const core::MatXQ& m) {
  Eigen::Matrix2d out;
  out << m(0, 0), m(0, 1), m(1, 0), m(1, 1);
  return out;
}

}  // namespace

FingerPhysics::FingerPhysics(const FingerParameters& parameters,
                             std::shared_ptr<const core::Kinematics> kinematics,
                             const Eigen::Vector2d& x)
    : p_(parameters), kinematics_(std::move(kinematics)), x_(x) {
  linkage_.q = core::VecQ::Zero(2);
  linkage_.J = core::MatXQ::Identity(2, 2);
  place();
  x_ += linkage_.out;
  place();
}

void FingerPhysics::place() noexcept {
  core::VecX wanted(2);
  wanted << x_[0], x_[1];
  core::VecQ q = linkage_.q;
  const core::InverseStatus inverse = kinematics_->inverse(wanted, q);
  core::VecX reached(2);
  core::MatXQ J = linkage_.J;
  if (kinematics_->evaluate(q, reached, J) != core::MapStatus::kOk) return;
  const Eigen::Matrix2d J2 = fixed(J);
  const double det = J2.determinant();
  if (!(std::abs(det) > 1e-9)) return;  // a toggle pose: keep the lever arms of the step before
  linkage_.q = q;
  linkage_.J = J;
  const int a = kinematics_->layout().actuated(0);
  linkage_.w = a == 0 ? Eigen::Vector2d(J2(1, 1) / det, -J2(0, 1) / det)
                      : Eigen::Vector2d(-J2(1, 0) / det, J2(0, 0) / det);
  linkage_.out.setZero();
  if (inverse != core::InverseStatus::kExact) {
    linkage_.out = Eigen::Vector2d(reached[0] - x_[0], reached[1] - x_[1]);
  }
}

/// w^T J_dot q_dot, m/s^2: how much l_x accelerates less than w^T x_ddot because J changes.
double FingerPhysics::velocity_product() const noexcept {
  const Eigen::Vector2d q_dot = fixed(linkage_.J).inverse() * x_dot_;
  Eigen::Vector2d J_dot_q_dot = Eigen::Vector2d::Zero();
  for (int k = 0; k < 2; ++k) {
    core::MatXQ J_k = core::MatXQ::Zero(2, 2);
    if (kinematics_->second_order(linkage_.q, k, J_k) != core::MapStatus::kOk) return 0.0;
    J_dot_q_dot += q_dot[k] * (fixed(J_k) * q_dot);
  }
  return linkage_.w.dot(J_dot_q_dot);
}

void FingerPhysics::step(double dt, const Eigen::Vector2d& x_des, double tau_a) noexcept {
  const Eigen::Vector2d w = linkage_.w;
  const Eigen::Matrix2d ww = w * w.transpose();
  const double reach_error = linkage_.out.norm();
  const Eigen::Vector2d n =
      reach_error > 0.0 ? Eigen::Vector2d(linkage_.out / reach_error) : Eigen::Vector2d::Zero();
  const double stop_damping = x_dot_.dot(n) < 0.0 ? p_.stop_damping : 0.0;

  Eigen::Matrix2d M = p_.actuator_mass * ww;
  M.diagonal() += p_.inertia;
  Eigen::Matrix2d A = M + dt * (p_.actuator_damping * ww + stop_damping * n * n.transpose());
  A.diagonal().array() += dt * p_.hand_damping;
  const Eigen::Vector2d spring = p_.hand_stiffness * (x_des - x_);
  const Eigen::Vector2d stop = p_.stop_stiffness * linkage_.out;
  const Eigen::Vector2d push = spring + stop + w * (tau_a + p_.actuator_mass * velocity_product());

  // Friction: F = F_c sign(l_dot), any |F| <= F_c at l_dot = 0, with l_dot the new speed.
  const Eigen::Matrix2d A_inverse = A.inverse();
  const Eigen::Vector2d sliding = A_inverse * (M * x_dot_ + dt * push);
  const Eigen::Vector2d per_newton = dt * (A_inverse * w);
  const double mobility = w.dot(per_newton);
  const double stick = mobility > 0.0 ? w.dot(sliding) / mobility : 0.0;
  const double friction = std::clamp(stick, -p_.actuator_friction, p_.actuator_friction);

  x_dot_ = sliding - friction * per_newton;
  const double l_dot_new = w.dot(x_dot_);
  energy_.by_user += dt * x_dot_.dot(spring - p_.hand_damping * x_dot_);
  energy_.by_actuator += dt * tau_a * l_dot_new;
  energy_.damping += dt * p_.actuator_damping * l_dot_new * l_dot_new;
  energy_.friction += dt * std::max(0.0, friction * l_dot_new);
  energy_.stop -= dt * (x_dot_.dot(stop) - stop_damping * x_dot_.dot(n) * x_dot_.dot(n));
  x_ += dt * x_dot_;
  place();
}

core::VecQ FingerPhysics::q_ahead(double ahead) const noexcept {
  core::VecX x(2);
  x << x_[0] + ahead * x_dot_[0], x_[1] + ahead * x_dot_[1];
  core::VecQ q = linkage_.q;
  static_cast<void>(kinematics_->inverse(x, q));
  return q;
}

double FingerPhysics::kinetic() const noexcept {
  const double l_dot = linkage_.w.dot(x_dot_);
  return 0.5 * (p_.inertia.dot(x_dot_.cwiseAbs2()) + p_.actuator_mass * l_dot * l_dot);
}

}  // namespace haptic::hw
