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
/// Curved gaps are linearised where x was in the tick before, solved, and linearised again there:
/// at most kMostSteps systems, kFirstSteps in the first tick of a sample, fewer with many contacts.

#include <array>
#include <vector>

#include "haptic/core/contacts/contact_dual.hpp"
#include "haptic/core/contacts/contact_laws.hpp"
#include "haptic/core/contacts/contacts.hpp"
#include "haptic/core/contacts/proxy_error.hpp"
#include "haptic/core/contacts/round_gap.hpp"
#include "haptic/core/model/configuration_space.hpp"
#include "haptic/core/model/task_metric.hpp"

namespace haptic::core {

enum class PlaneStatus : std::uint8_t {
  kFree = 0,        ///< no plane in the way: x = x_probe
  kActive = 1,      ///< held by at least one plane
  kInfeasible = 2,  ///< no x meets them all: least violation
};

class PlaneProjection {
 public:
  static constexpr int kMostSteps = 2;   ///< linearisations of curved gaps in a tick
  static constexpr int kFirstSteps = 8;  ///< in the first tick of a sample
  /// Most entries of G that the linearisations of a tick write.
  static constexpr int kMostEntries = 1056;
  /// Most multiplications that set() may spend for multipliers, and each tick; and one system more.
  static constexpr int kMostWork = 40'000;
  /// Most by which curvature may turn and lengthen a gradient of length 1: beyond, the contact is
  /// the plane that touches it there.
  static constexpr double kMostTurn = 1.0;

  /// `space` must outlive this. `metric`: W, of its n_x or the identity.
  explicit PlaneProjection(const ConfigurationSpace& space, TaskMetric metric = {});
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
  [[nodiscard]] double unexplained() const noexcept { return unexplained_; }
  [[nodiscard]] bool has_laws() const noexcept { return laws_.any(); }
  /// Number of calls of project() with one step that cost at most 20 us
  /// (core/METHOD.md#pushed-objects).
  [[nodiscard]] int replayable() const noexcept;
  /// Multiplications that the last set() or project() spent. With most_steps = 1 project() spends
  /// what was left.
  [[nodiscard]] int multiplications() const noexcept { return dual_.spent(); }
  [[nodiscard]] int linearisations() const noexcept { return linearisations_; }
  // After the last project():
  /// Every contact and how deep the probe is beyond it; one that was left out has direction 0 and
  /// depth -1.
  [[nodiscard]] const Contacts& contacts() const noexcept { return contacts_; }
  /// Bit i is set if contact i holds x.
  [[nodiscard]] std::uint32_t active() const noexcept { return dual_.held(); }
  /// Energy of the contacts, 1/2 sum max(0, -phi_i)^2 / gamma_i, and of the objects behind them.
  [[nodiscard]] double stored() const noexcept;
  /// That of the coupling in the same unit, 1/2 ||x (-) x_probe||_W^2.
  [[nodiscard]] double coupling() const noexcept;
  /// How far the client's own proxy may be from x, Eq. (39). `age_error`: of the age, s. Never
  /// allocates.
  void error(double age_error, ProxyError& out) const noexcept;

 private:
  using Vector = ContactDual::Vector;
  /// Coordinates in which a column is not 0: in a hand of many outputs few of them.
  struct Rows {
    int first{0}, count{0};
  };
  [[nodiscard]] static constexpr bool meet(Rows a, Rows b) noexcept {
    return a.first < b.first + b.count && b.first < a.first + a.count;
  }
  [[nodiscard]] Rows rows_of(int i) const noexcept { return rows_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] Rows rows_into(int i) const noexcept {
    return metric_.is_diagonal() ? rows_of(i) : Rows{0, static_cast<int>(A_.rows())};
  }

  /// Contact i, scaled so that its gradient has unit length in W^-1; or it is left out.
  void take(const PlaneSet& planes, int i) noexcept;
  /// Finds the coordinates that contact i names.
  void find_rows(int i) noexcept;
  /// Gradient of contact i times v (n_x).
  [[nodiscard]] double along(int i, const double* v) const noexcept;
  /// Divides column i of A_ and of D by its length, which is returned; 0: it has none.
  double normalise(int i) noexcept;
  /// Finds the contacts j <= i whose product with contact i may differ from 0.
  void find_meeting(int i) noexcept;
  void multiply(int i, int j) noexcept;
  /// Gives the dual its diagonal, and how far objects with a law give way.
  void fill_gram() noexcept;
  void fill_diagonal(int i) noexcept;
  /// Shifts beta_ so that the law gives at_ for the probe x_used.
  void anchor(const VecX& x_used) noexcept;
  void leave_as_told(const Vector& told_beta) noexcept;
  /// Multipliers that explain the displacement d of the client's own proxy, near those `told`.
  void explain(const VecX& d, const Vector& told, Vector& l) noexcept;
  [[nodiscard]] double shift(const VecX& d, const Vector& l, const Vector& told_beta) noexcept;
  /// Prepares error() for a new sample, before it is anchored.
  void begin_error(const PlaneSet& planes) noexcept;
  [[nodiscard]] double bend(int i) noexcept;
  [[nodiscard]] double unsettled(const VecX& moved) const noexcept;
  /// The shape of object and tool at contact i; of unknown shape if i does not tell it.
  [[nodiscard]] RoundGap round_gap(const PlaneSet& planes, int i) const noexcept;
  /// Beyond this share of its radius of curvature a displacement says nothing of the object.
  static constexpr double kMostBent = 0.9;
  /// How far a gap and its gradient may be from their second order at z_, and its second order
  /// there, at most.
  using Remainder = RoundGap::Off;
  /// Sines and cosines of the last finger; the contacts of one finger share them.
  struct LastTurn {
    int first{-1};
    RoundGap::Turn turn{};
  };
  /// `last` null: a shape that is known is not used.
  [[nodiscard]] Remainder remainder(int i, LastTurn* last) const noexcept;
  /// Length by which the anchor shifted the gap that contact i was told to have.
  [[nodiscard]] double shifted(int i) const noexcept;
  /// Parts of error(): how far x may be off, and then each contact. `left`: of curved contacts.
  /// False: nothing follows from gaps that are told whole (`whole`) so far off.
  bool proxy_error(double age_error, bool whole, Remainder* left, ProxyError& out) const noexcept;
  /// Errors that a sample leaves open, per contact i, in ||.||_W. x is off by `slope` because its
  /// stiffness is uncertain, and by `share` because other contacts may carry its force. Its gap may
  /// be off by `gap`, and x is `room` from touching it. Only the first `count_` entries are
  /// written: clearing the four arrays costs as much as all the rest.
  struct Open {
    double slope[kMaxPlanes], share[kMaxPlanes], gap[kMaxPlanes], room[kMaxPlanes];
    double bent{0.0};  ///< sum of l_i ||H_i||: the share of E that curvature adds, at most
    int involved{0};   ///< contacts that may push x elsewhere
    int only{-1};      ///< the last of them
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init)
    Open() noexcept {}
  };
  [[nodiscard]] Open what_is_open(double age_error, bool whole, Remainder* left) const noexcept;
  bool of_one_flat_contact(const Open& open, ProxyError& out) const noexcept;
  double of_each_contact(const Open& open, const Remainder* left, double* as_gap,
                         ProxyError& out) const noexcept;
  bool grow(const Open& open, double off, bool whole, const Remainder* left, const double* as_gap,
            ProxyError& out) const noexcept;
  void contact_errors(double age_error, const Remainder* left, ProxyError& out) const noexcept;
  /// Curved contacts become the planes that touch them at z_.
  void linearise() noexcept;
  /// Solves curved gaps where they are linearised, and again at the answer.
  PlaneStatus settle(double age, int most_steps) noexcept;
  [[nodiscard]] int most_linearisations(int most) const noexcept;
  PlaneStatus solve(double age) noexcept;
  void displace(VecX& x) const noexcept;
  /// Adds to v (n_x) what contact i moves with the multiplier l.
  void push(VecX& v, double l, int i) const noexcept;

  const ConfigurationSpace* space_;
  TaskMetric metric_;
  std::vector<bool> linear_{};  ///< per coordinate: the real line, no turns and no signs
  int count_{0};
  std::uint32_t skipped_{0};  ///< contacts that are left out
  std::uint32_t curved_{0};   ///< contacts with a curvature
  bool soft_{false}, moving_{false}, fresh_{false};
  bool begun_{false};  ///< it is known what pushed the objects at the sample
  VecX at_;
  PlaneSet::Normals A_{};                   ///< unit in W^-1
  Contacts contacts_{};                     ///< into: D = W^-1 A
  Vector beta_{}, gamma_{}, speed_{};       ///< of the scaled contacts; beta_ relative to at_
  PlaneSet::Normals told_{}, told_into_{};  ///< these five: at at_, columns of curved contacts
  Vector told_beta_{}, told_gamma_{}, told_speed_{};
  Vector scale_{};            ///< of a contact now by what it was at at_
  PlaneSet::Curvatures H_{};  ///< scaled
  PlaneSet::Places first_{}, n_curved_{};
  std::array<Rows, kMaxPlanes> rows_{};  ///< of A_
  std::array<std::uint32_t, kMaxPlanes>
      meeting_{};                        ///< bit j: (i, j) of these may be not 0, j <= i
  std::array<int, kMaxPlanes> begin_{};  ///< of each contact's curvature in H_
  ContactDual dual_{};
  ContactLaws laws_{};
  double unexplained_{0.0};
  // Parts of error(), if every contact tells its uncertainty:
  bool bounded_{false}, anchored_{false};
  bool explained_{false};  ///< but for a hundredth
  bool exact_{false};      ///< nothing moves a contact away from its law
  Vector uncertainty_{};   ///< u
  Vector anchored_l_{};    ///< multipliers at the anchor
  Vector told_l_{};        ///< those that the contacts are told to have there
  Vector unshifted_{};     ///< beta_ before it was anchored
  double unsettled_{0.0};  ///< by how much the last linearisation moved x, ||.||_W
  Vector bend_{};          ///< Frobenius norm of H, in W^-1
  std::array<RoundGap, kMaxPlanes> round_{};
  VecX y_{};  ///< the probe relative to at_
  VecX z_{};  ///< where curved gaps are linearised, relative to at_
  int linearisations_{0};
  double damped_{1.0};       ///< share of a step of z_ that is taken
  double step_before_{0.0};  ///< of that, max norm
  VecX y_before_{};          ///< y_ and age in the tick before
  double age_before_{0.0};
  VecX turn_{}, into_{};  ///< scratch
};

}  // namespace haptic::core
