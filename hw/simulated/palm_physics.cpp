#include "hw/simulated/palm_physics.hpp"

#include "haptic/core/model/rigid_pose.hpp"

namespace haptic::hw {
namespace {

Eigen::Quaterniond turned_by(const Eigen::Vector3d& phi) noexcept {
  const double angle = phi.norm();
  if (!(angle > 0.0)) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, phi / angle));
}

Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& q) noexcept {
  return core::rotation_vector({q.x(), q.y(), q.z(), q.w()});
}

/// One step of M x_ddot = K e + B (x_dot_des - x_dot) from velocity v; adds its work to `work`.
Eigen::Vector3d moved(double dt, double M, double K, double B, const Eigen::Vector3d& e,
                      const Eigen::Vector3d& v_des, const Eigen::Vector3d& v, double& work) {
  const Eigen::Vector3d after = (M * v + dt * (K * e + B * v_des)) / (M + dt * (B + dt * K));
  work += M * (after - v).dot(after);
  return after;
}

}  // namespace

PalmPhysics::PalmPhysics(const ArmParameters& parameters, const PalmPose& pose, double lower,
                         double upper)
    : p_(parameters),
      position_(pose.position.cwiseMax(lower).cwiseMin(upper)),
      orientation_(turned_by(pose.rotation)),
      intended_position_(pose.position),
      intended_orientation_(orientation_),
      lower_(lower),
      upper_(upper) {}

void PalmPhysics::step(double dt, const PalmPose& intended) noexcept {
  const Eigen::Quaterniond orientation = turned_by(intended.rotation);
  const Eigen::Vector3d v_des = (intended.position - intended_position_) / dt;
  const Eigen::Vector3d omega_des =
      rotation_vector(orientation * intended_orientation_.conjugate()) / dt;
  v_ = moved(dt, p_.mass, p_.stiffness, p_.damping, intended.position - position_, v_des, v_,
             by_arm_);
  omega_ =
      moved(dt, p_.inertia, p_.rotation_stiffness, p_.rotation_damping,
            rotation_vector(orientation * orientation_.conjugate()), omega_des, omega_, by_arm_);
  intended_position_ = intended.position;
  intended_orientation_ = orientation;

  const Eigen::Vector3d free = position_ + dt * v_;
  position_ = free.cwiseMax(lower_).cwiseMin(upper_);
  v_ = (position_.array() == free.array()).select(v_, 0.0);
  orientation_ = (turned_by(dt * omega_) * orientation_).normalized();
}

PalmPose PalmPhysics::ahead(double ahead) const noexcept {
  return {(position_ + ahead * v_).cwiseMax(lower_).cwiseMin(upper_),
          rotation_vector(turned_by(ahead * omega_) * orientation_)};
}

double PalmPhysics::kinetic() const noexcept {
  return 0.5 * (p_.mass * v_.squaredNorm() + p_.inertia * omega_.squaredNorm());
}

}  // namespace haptic::hw
