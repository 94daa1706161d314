#pragma once
/// Rendering per contact (core/METHOD.md#rendering-per-contact). The force that Eq. (8) wishes is
/// that of the spring Z_q at the actuators between probe and proxy, tau_8 = Z_q S J^+ dx. This rule
/// gives the nearest to it, as the finger feels the difference, that pushes the probe into no
/// contact:
///   min ||W (tau_a - tau_8)||  such that  out_i . W tau_a >= -slack_i,  |tau_a| <= limit,
/// W = (S J^+)^T and out_i the direction out of contact i. slack_i is the full push at the
/// surface and 0 at the depth `band`; it also grows as the motors' leverage on contact i vanishes.
/// So tau_a is continuous in q, x and the set of contacts.
///
/// Near a singular pose J^+ is damped, the earlier the more force there is, so that tau_a passes
/// through 0 where Eq. (8) changes its sign at full force; below condition 10 never
/// (core/METHOD.md#damping-near-singular-poses).

#include <array>
#include <optional>

#include "haptic/core/contacts/proxy_error.hpp"
#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/rendering/prior_target.hpp"
#include "haptic/core/rendering/projection.hpp"
#include "haptic/core/rendering/projection_model.hpp"

namespace haptic::core {

/// Depth at which a contact may no longer be pushed in, in ||.||_W: 0.25 deg of a joint, 0.5 mm of
/// a point; 0.05 in the scene's metric.
[[nodiscard]] double contact_band(const ProjectionModel& model) noexcept;

/// Calls visit(out, depth, i) for every contact that the probe is inside of, in the coordinates of
/// `model`: out (n_x) leads out, of length 1 in ||.||_W; i is its number, if the proxy has planes.
/// ContactView says what counts as a contact.
template <typename Visit>
void for_each_contact(const ProjectionModel& model, const ContactView& view, const VecX& dx,
                      bool by_joint, VecX& out, Visit&& visit) {
  if (view.contacts != nullptr) {
    for (int i = 0; i < view.contacts->size(); ++i) {
      if (!(view.contacts->depth[i] > 0.0)) continue;
      out = -view.contacts->into.col(i).segment(view.first_x, model.n_x());
      if ((out.array() != 0.0).any()) visit(out, view.contacts->depth[i], i);
    }
    return;
  }
  if (!by_joint) {
    VecX weighed = dx;
    model.metric().weigh(weighed);
    const double depth = weighed.norm();
    if (!(depth > 0.0)) return;
    out = dx / depth;
    visit(out, depth, 0);
    return;
  }
  VecX weighed;
  for (Eigen::Index k = 0; k < dx.size(); ++k) {
    if (dx[k] == 0.0) continue;
    out = dx;
    for (Eigen::Index j = 0; j < dx.size(); ++j) {
      if (j != k && dx[j] * dx[k] >= 0.0) out[j] = 0.0;
    }
    weighed = out;
    model.metric().weigh(weighed);
    out /= weighed.norm();
    weighed.setZero();
    weighed[k] = dx[k];
    model.metric().weigh(weighed);
    visit(out, weighed.norm(), 0);
  }
}

/// True if every coordinate is a joint angle.
[[nodiscard]] bool contacts_by_joint(const ProjectionModel& model) noexcept;

class PerContact {
 public:
  /// Throws SceneError: a prior on a map of n_x + n_q > kMaxX.
  explicit PerContact(const ProjectionModel& model);
  /// See Renderer::project.
  void project(const Probe& probe, const VecX& x, const VecX& dx, const VecA& stiffness,
               bool proxy_changed, Projection& out) noexcept;
  /// How far the last project()'s tau_a may be from the simulation's own: from `force` (n_a), how
  /// far tau_8 may be, and from the contacts' errors. False: nothing is known. `probe` and
  /// `stiffness`: as there. Never allocates.
  [[nodiscard]] bool widen(const Probe& probe, const VecA& stiffness, const ProxyError& error,
                           VecA& force) noexcept;
  /// Forgets q_n^ref.
  void reset() noexcept { target_.reset(); }

 private:
  // 1 / condition, of equilibrated columns:
  static constexpr double kDamped = 0.01;  ///< damping begins here or earlier,
  static constexpr double kNear = 0.1;     ///< and never before
  /// Within this the force goes to 0: a joint's 0.1 deg changes 1 / condition by 0.00175 or less.
  static constexpr double kRamp = 0.035;
  /// Share of its limit by which a way of x by `small_` may change a force.
  static constexpr double kGentle = 0.05;
  static constexpr int kMost = kMaxQ > kMaxPlanes ? kMaxQ : kMaxPlanes;
  struct Push {
    VecA out{};                      ///< S J^+ out_i: out . tau_a is what tau_a does along it
    double slack{0.0};               ///< share of the full push that is still allowed, 0 to 1
    double depth{0.0}, cosine{0.0};  ///< which it follows from; cosine: leverage()
    int contact{0};
  };

  /// The solver whose R holds for this pose: the plain one, or with damping or the prior.
  const LeastSquares& solve(const Probe& probe, const MatXQ& J, const VecX& d,
                            const VecA& stiffness, bool proxy_changed, Projection& out) noexcept;
  const LeastSquares& solve_with(const MatXQ& J, const VecX& d, const VecQ& weight,
                                 const VecQ& target, const VecA& stiffness) noexcept;
  /// 1 / condition below which tau_8 (n_a) is damped, of the plain solver's last J.
  [[nodiscard]] double damped_from(const ContactView& view, const VecA& stiffness,
                                   const VecA& tau) const noexcept;
  /// sqrt(lambda^2 M) for lambda^2 = `square`.
  [[nodiscard]] VecQ damping_weight(const MatXQ& J, const VecA& stiffness,
                                    double square) const noexcept;
  /// The force limits; 0 if there is no stiffness.
  [[nodiscard]] VecA most(const ContactView& view, const VecA& stiffness) const noexcept;
  /// tau_ <- the bounded optimum for several actuators. True: a contact held it back.
  bool hold_back(const LeastSquares& solver, const VecA& limit) noexcept;

  ProjectionModel model_;
  double band_;
  double small_;  ///< 0.1 deg of a joint, 0.1 mm of a point; 0.01 in the scene's metric
  bool by_joint_;
  LeastSquares solver_;
  std::optional<LeastSquares> extended_{};  ///< with n_q rows more, if there is room for them
  PriorTarget target_;
  std::array<Push, kMost> pushes_{};
  int pushed_{0};  ///< of these, in the last project()
  VecA tau_{};
  VecX dx_W_{}, out_{}, rhs_{};
  MatXQ J_W_{}, rows_{};
};

}  // namespace haptic::core
