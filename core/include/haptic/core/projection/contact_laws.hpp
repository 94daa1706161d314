#pragma once
/// Objects that are pushed: their own law of motion along the normal of each contact, integrated
/// in every tick with the force that is felt there, Eq. (38) (core/METHOD.md#pushed-objects):
///   M_i s_i'' = sum_j e_i.e_j sqrt(M_i / M_j) l_j + load_i - D_i s_i' - k_i s_i,
/// s_i how far the surface has receded since its sample, l_j the multipliers of the contacts on the
/// same object, e the directions in which they push it. By the trapezoidal rule s is linear in the
/// l that is looked for, so that contacts with a law are some that give way by free() + give() l,
/// for the same solver: stable for every mass, and as passive as the law; of several contacts on
/// one object if D_i / M_i and k_i / M_i are the same for all of them. Never allocates.

#include <array>

#include "haptic/core/projection/contact_dual.hpp"

namespace haptic::core {

class ContactLaws {
 public:
  using Vector = ContactDual::Vector;

  /// No contact has a law.
  void clear() noexcept {
    with_ = shared_ = 0;
    count_ = 0;
    others_.fill(0);
  }
  /// Contact i has the law of that column of PlaneSet::laws, and recedes at `velocity`; its gap is
  /// counted in units of `length`. A mass of 0 is no law.
  void take(const PlaneSet::Laws& told, int i, double velocity, double length) noexcept;
  /// Those that were taken push these objects. A direction without a length is of no object.
  void share(const PlaneSet::Objects& told) noexcept;
  [[nodiscard]] bool any() const noexcept { return with_ != 0; }
  [[nodiscard]] bool has(int i) const noexcept { return ContactDual::has(with_, i); }

  /// A step of dt s (>= 0) begins. True: give() may have changed.
  bool begin(double dt) noexcept;
  /// s at the end of the step if nothing pushed any more; 0 without a law.
  [[nodiscard]] double free(int i) const noexcept { return has(i) ? free_[i] : 0.0; }
  /// Contacts on the same object as contact i, which is not among them, as bits.
  [[nodiscard]] std::uint32_t others(int i) const noexcept {
    return others_[static_cast<std::size_t>(i)];
  }
  /// And by how much more per unit of contact j's l at the end of the step.
  [[nodiscard]] double give(int i, int j) const noexcept;
  /// The step ends with the multipliers l, one per contact. Those without a law are not read.
  void end(const Vector& l) noexcept;

  /// Of all objects, kinetic and of what holds them: M v^2 / 2 + (load - k s)^2 / (2 k). Of an
  /// object with several contacts what the one that has most knows of it, so never too much.
  [[nodiscard]] double energy() const noexcept;

 private:
  /// sum_j give(i, j) l_j.
  [[nodiscard]] double pushed(int i, const Vector& l) const noexcept;

  std::uint32_t with_{0};
  std::uint32_t shared_{0};  ///< contacts on an object that has others
  int count_{0};             ///< one more than the last contact with a law
  double dt_{0.0};
  Vector mass_{}, damping_{}, stiffness_{}, load_{};
  Vector s_{}, v_{}, l_{};  ///< at the end of the last step
  Vector free_{}, give_{};
  Vector root_{};                                   ///< sqrt(give)
  std::array<std::uint32_t, kMaxPlanes> others_{};  ///< contacts on the same object, as bits
  ContactDual::Gram cosine_{};  ///< e_i.e_j of contacts on one object, which are not the same
};

}  // namespace haptic::core
