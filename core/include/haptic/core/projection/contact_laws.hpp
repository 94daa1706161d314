#pragma once
/// Objects that are pushed: their own law of motion along the normal of each contact, integrated
/// in every tick with the force that is felt there, Eq. (38) (core/METHOD.md#pushed-objects):
///   M s'' = l + load - D s' - k s,
/// s how far the surface has receded since its sample, l the contact's multiplier. By the
/// trapezoidal rule s is linear in the l that is looked for, so that a contact with a law is one
/// that gives way by free() + give() l, for the same solver: stable for every mass, and as passive
/// as the law. Never allocates.

#include "haptic/core/projection/contact_dual.hpp"

namespace haptic::core {

class ContactLaws {
 public:
  /// No contact has a law.
  void clear() noexcept { with_ = 0; }
  /// Contact i has the law of that column of PlaneSet::laws, and recedes at `velocity`; its gap is
  /// counted in units of `length`. A mass of 0 is no law.
  void take(const PlaneSet::Laws& told, int i, double velocity, double length) noexcept;
  [[nodiscard]] bool any() const noexcept { return with_ != 0; }
  [[nodiscard]] bool has(int i) const noexcept { return ContactDual::has(with_, i); }

  /// A step of dt s (>= 0) begins. True: give() may have changed.
  bool begin(double dt) noexcept;
  /// s at the end of the step if nothing pushed any more; 0 without a law.
  [[nodiscard]] double free(int i) const noexcept { return has(i) ? free_[i] : 0.0; }
  /// And by how much more per unit of l at the end of the step.
  [[nodiscard]] double give(int i) const noexcept { return has(i) ? give_[i] : 0.0; }
  /// The step ends with the multiplier l.
  void end(int i, double l) noexcept;

  /// Of all objects, kinetic and of what holds them: M v^2 / 2 + (load - k s)^2 / (2 k).
  [[nodiscard]] double energy() const noexcept;

 private:
  using Vector = ContactDual::Vector;

  std::uint32_t with_{0};
  double dt_{0.0};
  Vector mass_{}, damping_{}, stiffness_{}, load_{};
  Vector s_{}, v_{}, l_{};  ///< at the end of the last step
  Vector free_{}, give_{};
};

}  // namespace haptic::core
