#pragma once
/// Objects that are pushed: their own law of motion along the normal of each contact, integrated
/// in every tick with the force that is felt there, Eq. (38) (core/METHOD.md#pushed-objects):
///   M_i s_i'' = sum_j e_i.e_j sqrt(M_i / M_j) l_j + load_i - D_i s_i' - k_i s_i,
/// s_i how far the surface has receded since its sample, l_j the multipliers of the contacts on the
/// same object, e the directions in which they push it. The trapezoidal rule makes s linear in the
/// unknown l, so a contact with a law gives way by free() + give() l in the same solver. It is
/// stable for every mass and as passive as the law. Several contacts on one object are so if D_i /
/// M_i and k_i / M_i are the same for all of them. Never allocates.

#include <array>

#include "haptic/core/contacts/contact_dual.hpp"
#include "haptic/core/contacts/mass_ratio.hpp"

namespace haptic::core {

class ContactLaws {
 public:
  using Vector = ContactDual::Vector;

  /// No contact has a law, and nothing is known of any mass.
  void clear() noexcept {
    begin_sample();
    known_ = 0;
  }
  /// The laws of a new sample's contacts, which recede at the velocities that it tells. Gaps are
  /// counted in units of `length`, one per contact; those in `left_out` have no law, and so has one
  /// of mass 0. A direction of length 0 belongs to no object. Knowledge of the
  /// masses is kept for the contacts that the sample names: they become those that explain the
  /// samples.
  void set(const PlaneSet& told, const Vector& length, std::uint32_t left_out) noexcept;
  /// Back to where the sample told them, and to what pushed them there.
  void rewind() noexcept;
  /// The next sample is of the end of the last step: what it tells is compared with that.
  void compare_next() noexcept { compared_ = true; }
  [[nodiscard]] bool any() const noexcept { return with_ != 0; }
  [[nodiscard]] bool has(int i) const noexcept { return ContactDual::has(with_, i); }

  /// A step of dt s (>= 0) begins. True: give() may have changed.
  bool begin(double dt) noexcept;
  /// s at the end of the step if nothing pushed any more; 0 without a law.
  [[nodiscard]] double free(int i) const noexcept { return has(i) ? free_[i] : 0.0; }
  /// And by how much more per unit of its own l at the end of the step.
  [[nodiscard]] double give(int i) const noexcept { return has(i) ? give_[i] : 0.0; }
  /// And by how much per unit of the l of the others on its object, scaled.
  [[nodiscard]] ContactDual::Gives gives(const Vector& scale) const noexcept;
  /// The step ends with the multipliers l, one per contact. Those without a law are not read.
  void end(const Vector& l) noexcept;

  /// Energy of all objects, kinetic and of what holds them: M v^2 / 2 + (load - k s)^2 / (2 k). For
  /// an object with several contacts what the one that has most knows of it, so never too much.
  [[nodiscard]] double energy() const noexcept;

 private:
  /// No contact has a law any more.
  void begin_sample() noexcept;
  void take(const PlaneSet& told, int i, double length) noexcept;
  void share(const PlaneSet::Objects& told) noexcept;
  void correct_masses() noexcept;
  /// Takes over what the sample before told of contact i's mass; returns what this one adds.
  [[nodiscard]] MassRatio::Seen recall(int i) noexcept;
  /// pushed_ becomes by how much the multipliers l push.
  void push(const Vector& l) noexcept;

  std::uint32_t with_{0};
  std::uint32_t shared_{0};  ///< contacts on an object that has others
  int count_{0};             ///< one more than the last contact with a law
  double dt_{0.0};
  Vector mass_{}, damping_{}, stiffness_{}, load_{};
  Vector s_{}, v_{}, l_{};  ///< at the end of the last step
  Vector first_l_{};        ///< at the sample: of steps of 0 s
  Vector free_{}, give_{};
  Vector root_{};                                   ///< sqrt(give)
  std::array<std::uint32_t, kMaxPlanes> others_{};  ///< contacts on the same object, as bits
  ContactDual::Gram cosine_{};  ///< e_i.e_j of different contacts on one object, else 0
  Vector pushed_{};

  // Knowledge of the masses:
  Vector id_{}, object_{};  ///< 0: none
  Vector told_v_{};         ///< at the sample
  Vector jump_{};           ///< most that a step since then changed l by, times its length
  double time_{0.0};        ///< since then, s
  std::array<MassRatio, kMaxPlanes> ratio_{};
  /// A contact of the sample before that had a name.
  struct Before {
    double id{0.0}, object{0.0};
    MassRatio ratio{};
    double v{0.0};       ///< as it was told
    double faster{0.0};  ///< by the law with the mass that was told, until the next sample
    double wrong{0.0};   ///< by how much that may be off
    double load{0.0};    ///< by then
  };
  std::array<Before, kMaxPlanes> before_{};
  int known_{0};          ///< of those
  bool compared_{false};  ///< the last steps lead to the next sample
  double compared_s_{0.0};
};

}  // namespace haptic::core
