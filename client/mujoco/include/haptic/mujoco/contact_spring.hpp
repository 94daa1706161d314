#pragma once
/// The spring that a MuJoCo contact is when it is held still.
///
/// MuJoCo gives each contact the reference acceleration a_ref = -B v - K d(r) r, with r the
/// penetration (negative), and exerts f = (a_ref - a) / R, R = (1 - d) / d A. A is its estimate of
/// J M^-1 J^T: the inverse mass that meets at the contact, from body_invweight0 of both bodies. At
/// rest (v = a = 0) that is a spring,
///
///   f = K d(r)^2 / ((1 - d(r)) A) |r|,
///
/// with K = 1 / (dmax timeconst dampratio)^2 for a positive solref, -solref[0] / dmax^2 for a
/// negative one, and d the impedance of solimp, which rises from d0 to dmax over its width. What
/// is left out is viscous (B / R, and a mass 1 / R) and ends with the motion. With the pyramidal
/// cone 2 (dim - 1) edges share the force, each with R = 2 mu^2 R_0, R_0 from A (1 + mu_0^2).

#include <mujoco/mujoco.h>

namespace haptic::mujoco {

class ContactSpring {
 public:
  /// `contact`: of d->contact; only its parameters are used, so it need not touch.
  ContactSpring(const mjModel& model, const mjContact& contact);

  /// Normal force, N, at a penetration of `depth` m (<= 0: none).
  [[nodiscard]] double force(double depth) const;
  /// df/d(depth), N/m, > 0.
  [[nodiscard]] double slope(double depth) const;
  /// Stiffness to tell for a contact, N/m: inside its slope; before it touches, what force over
  /// depth will be at half of solimp's width.
  [[nodiscard]] double stiffness(double depth) const;

 private:
  [[nodiscard]] double impedance(double depth) const;

  double solimp_[mjNIMP]{};
  double per_depth_{0.0};  ///< K / A and what the cone makes of it, N/m
};

}  // namespace haptic::mujoco
