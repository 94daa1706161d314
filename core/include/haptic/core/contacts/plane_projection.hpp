#pragma once
/// The client's projection, done by the server in every tick, Eq. (27)
/// (core/METHOD.md#local-models), and with contacts Eq. (36) (core/METHOD.md#contacts):
///   x = argmin 1/2 ||x (-) x_probe||_W^2 + 1/2 sum_i max(0, -phi_i(x))^2 / gamma_i,
/// phi_i the gaps of at most kMaxPlanes contacts (PlaneSet); gamma_i = 0 means phi_i >= 0. W is the
/// scene's metric W_x: what is near for the planes is what is near for the renderer
/// (core/METHOD.md#metric-and-limits). Solved on the dual (contact_dual.hpp), with gradients of
/// unit length in W^-1, so that planes, which have neither compliance nor curvature, have
///   parallel, redundant   the same x as without the superfluous ones
///   opposite, infeasible  the x of least violation, min sum (n_i^T x - b_i)^2 with unit normals,
///                         that is nearest to x_probe; status kInfeasible
/// If they can be met x meets them to rounding. Planes that meet only beyond some hundred times
/// their violation (an acute wedge seen from outside) count as infeasible; x is continuous there,
/// and at most 4900 times the violations away.
///
/// Its parts: what the client told (contact_gaps.hpp) and where that is anchored
/// (contact_anchor.hpp), the solver (contact_solver.hpp), the laws of pushed objects
/// (contact_laws.hpp), and the error bound, which reads them (proxy_bound.hpp).

#include <utility>

#include "haptic/core/contacts/proxy_bound.hpp"

namespace haptic::core {

class PlaneProjection {
 public:
  static constexpr int kMostSteps = ContactSolver::kMostSteps;
  static constexpr int kMostWork = ContactSolver::kMostWork;

  /// `space` must outlive this. `metric`: W, of its n_x or the identity.
  explicit PlaneProjection(const ConfigurationSpace& space, TaskMetric metric = {})
      : gaps_(space, std::move(metric)) {}
  PlaneProjection(const PlaneProjection&) = delete;
  PlaneProjection& operator=(const PlaneProjection&) = delete;

  /// From now on these contacts, around `x` (n_x). A contact without a direction, or with a number
  /// that is not finite, is left out. `x_used` (n_x), if not null: the haptic probe from which the
  /// simulation computed x, its own proxy; the gaps are shifted so that the law gives x there
  /// (core/METHOD.md#contacts), and unexplained() is what no shift explains. More than some twenty
  /// rigid contacts can exceed kMostWork: they are then taken as they were told. With a W that is
  /// not diagonal 2 n_x^2 multiplications per contact; otherwise n_x. Never allocates.
  void set(const PlaneSet& planes, const VecX& x, const VecX* x_used = nullptr) noexcept;

  /// The next set() begins a stream of samples: nothing is known of masses.
  void forget_masses() noexcept { laws_.clear(); }
  /// After a set() with x_used. True: it is known what pushes objects with a law there, and
  /// the first project() goes on from there by its dt.
  [[nodiscard]] bool begin_at_anchor() noexcept;
  /// Back to the sample: the next project() goes on from there by its dt. If the calls from there
  /// on lead to where the next set() begins, that learns from what it tells of the objects'
  /// velocities by how much their masses are told wrong (core/METHOD.md#pushed-objects).
  void rewind() noexcept;

  /// Writes x (n_x) for the haptic probe, `age` s after the sample. A linear coordinate that no
  /// active plane moves keeps the bits of the probe. (If W is not diagonal a plane also moves
  /// coordinates that it does not name.) Never allocates.
  /// `dt`: s since the last call, by which objects with a law move on; the first call after a set()
  /// finds them where they were told, unless begin_at_anchor().
  PlaneStatus project(const VecX& x_probe, VecX& x, double age = 0.0, double dt = 0.0,
                      int most_steps = kMostSteps) noexcept;

  /// After the last set(): ||x (-) what the law gives at x_used||_W; 0 without x_used.
  [[nodiscard]] double unexplained() const noexcept { return anchor_.unexplained(); }
  [[nodiscard]] bool has_laws() const noexcept { return laws_.any(); }
  /// Number of calls of project() with one step that cost at most 20 us
  /// (core/METHOD.md#pushed-objects).
  [[nodiscard]] int replayable() const noexcept;
  /// Multiplications that the last set() or project() spent. With most_steps = 1 project() spends
  /// what was left.
  [[nodiscard]] int multiplications() const noexcept { return solver_.multiplications(); }
  [[nodiscard]] int linearisations() const noexcept { return solver_.linearisations(); }
  // After the last project():
  /// Every contact and how deep the probe is beyond it; one that was left out has direction 0 and
  /// depth -1.
  [[nodiscard]] const Contacts& contacts() const noexcept { return gaps_.contacts(); }
  /// Bit i is set if contact i holds x.
  [[nodiscard]] std::uint32_t active() const noexcept { return solver_.held(); }
  /// Energy of the contacts, 1/2 sum max(0, -phi_i)^2 / gamma_i, and of the objects behind them.
  [[nodiscard]] double stored() const noexcept;
  /// That of the coupling in the same unit, 1/2 ||x (-) x_probe||_W^2.
  [[nodiscard]] double coupling() const noexcept;
  /// How far the client's own proxy may be from x, Eq. (39). `age_error`: of the age, s. Never
  /// allocates.
  void error(double age_error, ProxyError& out) const noexcept { bound_.at(age_error, out); }

 private:
  ContactGaps gaps_;
  ContactLaws laws_{};
  ContactSolver solver_{gaps_, laws_};
  ContactAnchor anchor_{gaps_, solver_};
  ProxyBound bound_{gaps_, solver_, anchor_};
  bool begun_{false};  ///< it is known what pushed the objects at the sample
  VecX y_{};           ///< the probe relative to the sample's x
};

}  // namespace haptic::core
