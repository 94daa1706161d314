#pragma once
/// Solves the proxy's problem for the gaps of a sample, Eqs. (27) and (36)
/// (core/METHOD.md#contacts): with r = -phi at the probe and the multipliers l of ContactDual, the
/// proxy is y - W^-1 A^T l, and the violation of a contact is gamma_i l_i.
///
/// Curved gaps are linearised where x was in the tick before, solved, and linearised again there.
/// Never allocates after construction.

#include "haptic/core/contacts/contact_gaps.hpp"

namespace haptic::core {

enum class PlaneStatus : std::uint8_t {
  kFree = 0,        ///< no plane in the way: x = x_probe
  kActive = 1,      ///< held by at least one plane
  kInfeasible = 2,  ///< no x meets them all: least violation
};

class ContactSolver {
 public:
  using Vector = ContactDual::Vector;
  static constexpr int kMostSteps = 2;   ///< linearisations of curved gaps in a tick
  static constexpr int kFirstSteps = 8;  ///< in the first tick of a sample
  /// Most entries of G that the linearisations of a tick write.
  static constexpr int kMostEntries = 1056;
  /// Most multiplications that a new sample may spend for multipliers, and each tick; and one
  /// system more.
  static constexpr int kMostWork = 40'000;

  /// Both must outlive this.
  ContactSolver(ContactGaps& gaps, const ContactLaws& laws) : gaps_(gaps), laws_(laws) {}

  /// The gaps are those of a new sample. None is held.
  void begin() noexcept;
  /// After a change of gamma, or of how far objects with a law give way: of all contacts, or of i.
  void fill() noexcept;
  void fill(int i) noexcept;
  /// Multipliers for the probe at y, `age` s after the sample, by the gaps as they are linearised.
  PlaneStatus solve(const VecX& y, double age) noexcept;
  /// The same of a tick: curved gaps are linearised at most `most_steps` times. With 1 it spends
  /// what is left of the work that was granted before.
  PlaneStatus project(const VecX& y, double age, int most_steps) noexcept;

  [[nodiscard]] ContactDual& dual() noexcept { return dual_; }
  [[nodiscard]] const Vector& l() const noexcept { return dual_.l(); }
  [[nodiscard]] std::uint32_t held() const noexcept { return dual_.held(); }
  // After the last project():
  [[nodiscard]] int multiplications() const noexcept { return dual_.spent(); }
  [[nodiscard]] int linearisations() const noexcept { return linearisations_; }
  /// If gaps curve: y of x, and how far from it they are linearised, in ||.||_W.
  [[nodiscard]] const VecX& at() const noexcept { return at_; }
  [[nodiscard]] double unsettled() const noexcept { return unsettled_; }

 private:
  PlaneStatus settle(const VecX& y, double age, int most_steps) noexcept;
  /// The share of the step that z_ takes.
  void damp(double step, bool theirs) noexcept;

  ContactGaps& gaps_;
  const ContactLaws& laws_;
  ContactDual dual_{};
  bool fresh_{false};  ///< no project() since begin()
  VecX z_{}, step_{}, at_{};
  double unsettled_{0.0};
  int linearisations_{0};
  double damped_{1.0};       ///< share of a step of z_ that is taken
  double step_before_{0.0};  ///< of that, max norm
  VecX y_before_{};          ///< y and age in the tick before
  double age_before_{0.0};
};

}  // namespace haptic::core
