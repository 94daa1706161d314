#pragma once
/// How far the client's own proxy may be from x, Eq. (39) (core/METHOD.md#error-bound): it reads
/// what the sample told, where that is anchored and what the solver found. Never allocates.

#include <array>

#include "haptic/core/contacts/contact_anchor.hpp"
#include "haptic/core/contacts/proxy_error.hpp"
#include "haptic/core/contacts/round_gap.hpp"

namespace haptic::core {

class ProxyBound {
 public:
  using Vector = ContactDual::Vector;

  /// All must outlive this.
  ProxyBound(const ContactGaps& gaps, const ContactSolver& solver, const ContactAnchor& anchor)
      : gaps_(gaps), solver_(solver), anchor_(anchor) {}

  /// A new sample, whose gaps are not anchored yet. `laws`: an object has a law of its own, which
  /// may be wrong in ways that no uncertainty of a stiffness tells.
  void set(const PlaneSet& told, bool laws) noexcept;
  /// The bound for the solver's last answer. `age_error`: error of the sample's age, s.
  void at(double age_error, ProxyError& out) const noexcept;

 private:
  /// How far a gap and its gradient may be from their second order where they are linearised, and
  /// its second order there, at most.
  using Remainder = RoundGap::Off;
  /// Sines and cosines of the last finger; the contacts of one finger share them.
  struct LastTurn {
    int first{-1};
    RoundGap::Turn turn{};
  };
  /// Errors that a sample leaves open, per contact i, in ||.||_W. x is off by `slope` because its
  /// stiffness is uncertain, and by `share` because other contacts may carry its force. Its gap may
  /// be off by `gap`, and x is `room` from touching it. Only as many entries are written as there
  /// are contacts: clearing the four arrays costs as much as all the rest.
  struct Open {
    double slope[kMaxPlanes], share[kMaxPlanes], gap[kMaxPlanes], room[kMaxPlanes];
    double bent{0.0};  ///< sum of l_i ||H_i||: the share of E that curvature adds, at most
    int involved{0};   ///< contacts that may push x elsewhere
    int only{-1};      ///< the last of them
    int other{-1};     ///< the last but one
    bool few{false};   ///< no third one is within reach
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init)
    Open() noexcept {}
  };

  /// Beyond this share of its radius of curvature a displacement says nothing of the object.
  static constexpr double kMostBent = 0.5;
  /// Nor does x if the forces turn by more than this share of its own way.
  static constexpr double kMostPressed = 0.8;
  /// And beyond this share of it the error itself says nothing.
  static constexpr double kMostFar = 0.1;
  /// Gap errors of several rigid contacts whose gradients are 30 degrees apart or more.
  static constexpr double kWedge = 2.0;

  /// Frobenius norm of the curvature of contact i in W^-1.
  [[nodiscard]] double bend(int i) const noexcept;
  /// The shape of object and tool at contact i; of unknown shape if i does not tell it.
  [[nodiscard]] RoundGap round_gap(const PlaneSet& told, int i) const noexcept;
  [[nodiscard]] Remainder remainder(int i, LastTurn& last) const noexcept;
  [[nodiscard]] Remainder of_any_shape(int i, const double* z) const noexcept;
  /// How far x may be off. `left`: of curved contacts.
  void proxy_error(double age_error, Remainder* left, ProxyError& out) const noexcept;
  [[nodiscard]] Open what_is_open(double age_error, Remainder* left) const noexcept;
  bool of_one_flat_contact(const Open& open, ProxyError& out) const noexcept;
  [[nodiscard]] double per_gap(const Open& open, int i, double gamma) const noexcept;
  [[nodiscard]] bool few(const Open& open, double way) const noexcept;
  double of_each_contact(Open& open, const Remainder* left, ProxyError& out) const noexcept;
  bool grow(const Open& open, double off, const Remainder* left, ProxyError& out) const noexcept;
  [[nodiscard]] bool wedged(const Open& open) const noexcept;
  [[nodiscard]] bool only_minimum(const Open& open, const Remainder* left) const noexcept;
  void contact_errors(double age_error, const Remainder* left, ProxyError& out) const noexcept;

  const ContactGaps& gaps_;
  const ContactSolver& solver_;
  const ContactAnchor& anchor_;
  bool told_{false};   ///< every contact tells its uncertainty
  bool plain_{false};  ///< none curves, moves or is uncertain
  Vector uncertainty_{}, bend_{};
  std::array<RoundGap, kMaxPlanes> round_{};
};

}  // namespace haptic::core
