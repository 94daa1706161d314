#pragma once
/// The client's projection, done by the server in every tick, Eq. (27)
/// (core/METHOD.md#local-models):
///   x = argmin ||x (-) x_probe||_W^2  such that  n_i^T x <= b_i,  at most kMaxPlanes planes,
/// W the scene's metric W_x: what is near for the planes is what is near for the renderer
/// (core/METHOD.md#metric-and-limits). Solved by an active set on the dual, min 1/2 l^T (G + eps) l
/// - l^T r over l >= 0 with G = A W^-1 A^T and unit normals in W^-1. The small eps makes every set
/// of planes have one answer:
///   parallel, redundant   the same x as without the superfluous ones
///   opposite, infeasible  the x of least violation, min sum (n_i^T x - b_i)^2 with unit normals,
///                         that is nearest to x_probe; status kInfeasible
/// If the planes can be met, eps is iterated away: x meets them to rounding. Planes that meet
/// only beyond some hundred times their violation (an acute wedge seen from outside) count as
/// infeasible. The work per tick is bounded: after kMostSolves systems of equations, which only
/// planes that contradict each other by the dozen need, what was reached is the answer.

#include <vector>

#include "haptic/core/model/configuration_space.hpp"
#include "haptic/core/projection/contacts.hpp"
#include "haptic/core/projection/task_metric.hpp"

namespace haptic::core {

enum class PlaneStatus : std::uint8_t {
  kFree = 0,        ///< no plane in the way: x = x_probe
  kActive = 1,      ///< held by at least one plane
  kInfeasible = 2,  ///< no x meets them all: least violation
};

class PlaneProjection {
 public:
  /// `space` must outlive this. `metric`: W, of its n_x or the identity.
  explicit PlaneProjection(const ConfigurationSpace& space, TaskMetric metric = {});

  /// From now on these planes, linearised at `x` (n_x). A plane whose normal is 0 is left out. With
  /// a W that is not diagonal 2 n_x^2 multiplications per plane; otherwise n_x. Never allocates.
  void set(const PlaneSet& planes, const VecX& x) noexcept;

  /// Writes x (n_x) for the haptic probe. A linear coordinate that no active plane moves keeps the
  /// bits of the probe. (If W is not diagonal a plane also moves coordinates that it does not
  /// name.) Never allocates.
  PlaneStatus project(const VecX& x_probe, VecX& x) noexcept;

  /// Of the last project(): every plane and how deep the probe is beyond it; a plane that was left
  /// out has direction 0 and depth -1.
  [[nodiscard]] const Contacts& contacts() const noexcept { return contacts_; }
  /// Of the last project(): bit i is set where plane i holds x.
  [[nodiscard]] std::uint32_t active() const noexcept { return active_; }

 private:
  using Small = Eigen::Matrix<double, kMaxPlanes, 1>;
  using Gram = Eigen::Matrix<double, kMaxPlanes, kMaxPlanes, Eigen::RowMajor>;
  static constexpr int kMostSolves = 3 * kMaxPlanes;

  /// l_ and active_ for violations r of x_probe, the deepest of them > 0.
  PlaneStatus multipliers(const Small& r, double deepest) noexcept;
  /// l_ = argmin 1/2 l^T (G + eps) l - l^T r, l >= 0 (C. L. Lawson and R. J. Hanson's active set),
  /// from the l_ that is there; at most `left` systems of equations, which it counts down.
  void solve(const Small& r, int& left) noexcept;
  /// Goes from l_ towards the solution on the planes held, which lose those that it would make < 0.
  void settle(const Small& r, double largest, int& left) noexcept;
  /// s = (G + eps)^-1 r on the planes held, in their order.
  void solve_held(const Small& r, Small& s) noexcept;
  /// (G + eps) l_ at plane i.
  [[nodiscard]] double pushed(int i) const noexcept;
  void hold_none() noexcept;

  const ConfigurationSpace* space_;
  TaskMetric metric_;
  std::vector<bool> linear_{};  ///< per coordinate: the real line, no turns and no signs
  int count_{0};
  std::uint32_t skipped_{0};  ///< planes without a direction
  VecX at_;
  PlaneSet::Normals A_{};  ///< unit in W^-1
  Contacts contacts_{};    ///< into: D = W^-1 A
  Small beta_{};           ///< offsets relative to at_
  Gram G_{};
  Small l_{};               ///< > 0 for the planes held, else 0
  int held_[kMaxPlanes]{};  ///< the planes held, in the order in which they came
  int n_held_{0};
  Gram L_{};                 ///< of Cholesky, in that order
  int factored_{0};          ///< rows of L_ that hold
  std::uint32_t active_{0};  ///< the planes held, as bits
  VecX y_{};
};

}  // namespace haptic::core
