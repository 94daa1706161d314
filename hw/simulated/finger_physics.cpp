#include "hw/simulated/finger_physics.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>

#include "haptic/core/error.hpp"

namespace haptic::hw {
namespace {

constexpr double kFastest = 100.0;  // rad/s

}  // namespace

std::shared_ptr<const core::FingerExoskeleton> require_finger(
    const std::shared_ptr<const core::Kinematics>& kinematics) {
  auto finger = std::dynamic_pointer_cast<const core::FingerExoskeleton>(kinematics);
  if (finger) return finger;
  throw core::DeviceError(
      "simulated_finger: the kinematics has " + std::to_string(kinematics->layout().n_q()) +
      " DoF(s), " + std::to_string(kinematics->layout().n_a()) + " actuated, and " +
      std::to_string(kinematics->space().n_x()) + " coordinate(s); must be finger_exoskeleton");
}

FingerPhysics::FingerPhysics(const FingerParameters& parameters,
                             const std::shared_ptr<const core::Kinematics>& kinematics,
                             const Eigen::Vector2d& x)
    : p_(parameters),
      hand_stiffness_(parameters.hand_stiffness),
      finger_(require_finger(kinematics)),
      x_(x) {
  linkage_.q = core::VecQ::Zero(2);
  search();
  x_ += linkage_.out;
  linkage_.out.setZero();
}

/// Finding the nearest pose in reach is a search of about 0.2 ms, too long for every step of a loop
/// at 1 kHz. So outside the reach there is at most one search in kSearchEvery steps, and none while
/// the finger leans on the edge without sliding; in between Newton's step follows the linkage.
void FingerPhysics::place() noexcept {
  constexpr int kSearchEvery = 10;  // steps: 1 ms at 10 kHz
  constexpr double kSlide = 0.005;  // rad
  ++steps_since_search_;
  const bool slid = (x_ - searched_at_).norm() >= kSlide;
  if (edge_.known() && (steps_since_search_ < kSearchEvery || !(slid || in_reach()))) {
    follow_edge();
  } else {
    search();
  }
}

void FingerPhysics::search() noexcept {
  searched_at_ = x_;
  steps_since_search_ = 0;
  linkage_.out.setZero();
  core::FingerExoskeleton::Motion at;
  if (finger_->follow(x_, x_dot_, at) == core::InverseStatus::kExact) {
    edge_.clear();
    if (!adopt(at, x_)) linkage_.pull = velocity_product();
    return;
  }
  core::VecX wanted(2);
  wanted << x_[0], x_[1];
  core::VecQ q = linkage_.q;
  const bool inside = finger_->inverse(wanted, q) == core::InverseStatus::kExact;
  if (inside) edge_.clear();
  if (!move_to(q) || inside) return;
  edge_.add(x_, linkage_.reached);
  linkage_.out = linkage_.reached - x_;
}

void FingerPhysics::follow_edge() noexcept {
  const Eigen::Vector2d allowed = edge_.nearest(x_);
  linkage_.out = allowed - x_;
  const Eigen::Vector2d change = to_q(allowed - linkage_.reached);
  core::VecQ q = linkage_.q;
  q[0] += change[0];
  q[1] += change[1];
  static_cast<void>(move_to(boxed(q)));
}

/// Moves the linkage to q. False if it cannot close there or adopt() refuses it.
bool FingerPhysics::move_to(const core::VecQ& q) noexcept {
  core::VecX reached;
  core::MatXQ J;
  core::FingerExoskeleton::Motion at;
  bool adopted = finger_->evaluate(q, reached, J) == core::MapStatus::kOk;
  if (adopted) {
    at.q = q;
    at.J = J;
    adopted = adopt(at, reached);
  }
  linkage_.pull = velocity_product();
  return adopted;
}

/// Takes that as the linkage's pose. False, and the pose stays, if it would be in a toggle
/// position: the lever arms of the step before are then the better ones.
bool FingerPhysics::adopt(const core::FingerExoskeleton::Motion& at,
                          const Eigen::Vector2d& reached) noexcept {
  constexpr double kToggle = 1e-9;  // 1/m; the valid region has det J > 2
                                    // (core/METHOD.md#finger-linkage)
  const Eigen::Matrix2d& J = at.J;
  const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
  if (!(std::abs(det) > kToggle) || det * linkage_.det < 0.0) return false;
  linkage_.q = at.q;
  linkage_.J = J;
  linkage_.det = det;
  linkage_.reached = reached;
  linkage_.w = finger_->layout().actuated(0) == 0 ? Eigen::Vector2d(J(1, 1), -J(0, 1))
                                                  : Eigen::Vector2d(-J(1, 0), J(0, 0));
  linkage_.w /= det;
  linkage_.pull = linkage_.w.dot(at.product);
  return true;
}

core::VecQ FingerPhysics::boxed(core::VecQ q) const noexcept {
  for (int i = 0; i < 2; ++i) {
    const core::DofSpec& dof = finger_->dofs()[static_cast<std::size_t>(i)];
    q[i] = std::clamp(q[i], dof.lower, dof.upper);
  }
  return q;
}

/// J^-1 times a small change of x (or x_dot): the change of q (or q_dot).
Eigen::Vector2d FingerPhysics::to_q(const Eigen::Vector2d& x_change) const noexcept {
  return linkage_.J.inverse() * x_change;
}

/// w^T J_dot q_dot, m/s^2: how much l_x accelerates less than w^T x_ddot because J changes.
double FingerPhysics::velocity_product() const noexcept {
  Eigen::Vector2d product;
  if (finger_->velocity_product(linkage_.q, to_q(x_dot_), product) != core::MapStatus::kOk) {
    return 0.0;
  }
  return linkage_.w.dot(product);
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
  const Eigen::Vector2d spring = hand_stiffness_ * (x_des - x_);
  const Eigen::Vector2d stop = p_.stop_stiffness * linkage_.out;
  const Eigen::Vector2d push = spring + stop + w * (tau_a + p_.actuator_mass * linkage_.pull);

  // Friction: F = F_c sign(l_dot), any |F| <= F_c at l_dot = 0, with l_dot the new speed.
  const Eigen::Matrix2d A_inverse = A.inverse();
  const Eigen::Vector2d sliding = A_inverse * (M * x_dot_ + dt * push);
  const Eigen::Vector2d per_newton = dt * (A_inverse * w);
  const double mobility = w.dot(per_newton);
  const double stick = mobility > 0.0 ? w.dot(sliding) / mobility : 0.0;
  const double friction = std::clamp(stick, -p_.actuator_friction, p_.actuator_friction);

  x_dot_ = sliding - friction * per_newton;
  // Near a toggle position, at the edge of the reach, w grows without bound and explicit steps
  // would make the speed grow with it. No finger is this fast.
  if (const double speed = x_dot_.norm(); speed > kFastest) x_dot_ *= kFastest / speed;
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
  const Eigen::Vector2d change = ahead * to_q(x_dot_);
  core::VecQ q = linkage_.q;
  q[0] += change[0];
  q[1] += change[1];
  return boxed(q);
}

double FingerPhysics::kinetic() const noexcept {
  const double l_dot = linkage_.w.dot(x_dot_);
  return 0.5 * (p_.inertia.dot(x_dot_.cwiseAbs2()) + p_.actuator_mass * l_dot * l_dot);
}

}  // namespace haptic::hw
