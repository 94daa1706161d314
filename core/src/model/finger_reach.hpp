#pragma once
/// The set of poses the finger's subspace proxy may take (box, slider limits, the branch det J >
/// 0), and the nearest of them to an x outside its image: Eq. (6) where x is unreachable
/// (core/METHOD.md#worst-cases).
///
/// At construction the edge of the set is traced once, as points that know which constraint they
/// lie on. nearest() takes the best traced point of each constraint and slides it along its curve
/// by 1-D Gauss-Newton steps. Since det J does not vanish inside, a minimum with a residual lies on
/// the edge: the answer is global up to the trace's grid, and needs no seed, no history, no
/// allocation.

#include <vector>

#include "finger_linkage.hpp"
#include "haptic/core/model/kinematics.hpp"

namespace haptic::core {

struct ReachPoint {
  double l{0.0}, t{0.0};
  double q1{0.0}, q2{0.0};
  int constraint{0};
};

class FingerReach {
 public:
  /// `linkage` must outlive this. Throws SceneError where no pose is feasible.
  explicit FingerReach(const FingerLinkage& linkage);

  /// The sliders' ends and the branch, the latter without a slope while it is far off. False where
  /// the linkage does not close.
  [[nodiscard]] bool constraints(double l, double t, Constraints& out) const noexcept;
  /// argmin ||x - f(q)|| over the set's edge.
  [[nodiscard]] ReachPoint nearest(double q1, double q2) const noexcept;
  /// Mean ||J_a|| over the valid region of core/METHOD.md#finger-linkage on the trace's grid,
  /// rad/m.
  [[nodiscard]] double mean_actuated_jacobian() const noexcept { return mean_J_a_; }

 private:
  static constexpr int kConstraints = 9;
  static constexpr int kGrid = 160;

  [[nodiscard]] double value(int constraint, double l, double t,
                             const LinkagePose& pose) const noexcept;
  /// The first limit that does not hold, or -1. `but`: not this one.
  [[nodiscard]] int violated(double l, double t, int but = -1) const noexcept;
  [[nodiscard]] bool gradient(int constraint, double l, double t, const LinkagePose& pose,
                              double& g_l, double& g_t) const noexcept;
  void trace();
  void add_crossing(double l_in, double t_in, double l_out, double t_out);
  void add(double l, double t, int constraint);
  [[nodiscard]] bool restore(int constraint, double& l, double& t) const noexcept;
  [[nodiscard]] ReachPoint slide(ReachPoint from, double q1, double q2) const noexcept;

  const FingerLinkage& linkage_;
  std::vector<ReachPoint> edge_;
  double mean_J_a_{0.0};
};

}  // namespace haptic::core
