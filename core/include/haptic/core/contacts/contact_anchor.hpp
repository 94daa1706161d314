#pragma once
/// Where the contacts of a sample are anchored, Eq. (37) (core/METHOD.md#contacts): their gaps are
/// shifted so that the law gives the simulation's own proxy, y = 0, at the probe from which the
/// simulation computed it. Never allocates.

#include "haptic/core/contacts/contact_solver.hpp"

namespace haptic::core {

class ContactAnchor {
 public:
  using Vector = ContactDual::Vector;

  /// Both must outlive this.
  ContactAnchor(ContactGaps& gaps, ContactSolver& solver) : gaps_(gaps), solver_(solver) {}

  /// The contacts of a new sample are as they were told.
  void clear() noexcept {
    known_ = false;
    unexplained_ = 0.0;
  }
  /// `d`: y of the probe from which the sample was computed. If the work that a sample may cost
  /// (ContactDual::allow) does not suffice, the contacts stay as they were told.
  void set(const VecX& d) noexcept;

  /// False: the contacts are as they were told, and only unexplained() means something.
  [[nodiscard]] bool known() const noexcept { return known_; }
  /// ||d - what the law explains of it||_W; 0 before set().
  [[nodiscard]] double unexplained() const noexcept { return unexplained_; }
  /// No more than a hundredth of d is left.
  [[nodiscard]] bool explained() const noexcept { return explained_; }
  /// The multipliers there, and those that the contacts are told to have there.
  [[nodiscard]] const Vector& l() const noexcept { return l_; }
  [[nodiscard]] const Vector& told_l() const noexcept { return told_l_; }
  /// These are the same, but for rounding.
  [[nodiscard]] bool as_told() const noexcept { return as_told_; }
  /// Length by which each gap was shifted, in ||.||_W.
  [[nodiscard]] const Vector& shift() const noexcept { return shift_; }

 private:
  /// l_ for a d of that length. False: the work that a sample may cost is spent.
  [[nodiscard]] bool choose(const VecX& d, double length) noexcept;
  /// Multipliers for the told gaps: how deep the contacts are, as far as `d` allows that.
  void find_told(const VecX& d, double length) noexcept;
  /// Multipliers that explain d, near those `told`.
  void explain(const VecX& d, const Vector& told, Vector& l) noexcept;
  /// Shifts the gaps so that l explains d. Returns how far that leaves x from the simulation's own.
  [[nodiscard]] double shift(const VecX& d, const Vector& l) noexcept;
  void leave_as_told() noexcept;

  ContactGaps& gaps_;
  ContactSolver& solver_;
  bool known_{false}, explained_{false}, as_told_{false};
  double unexplained_{0.0};
  Vector l_{}, told_l_{}, shift_{};
  Vector told_beta_{};
};

}  // namespace haptic::core
