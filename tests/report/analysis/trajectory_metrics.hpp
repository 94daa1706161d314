#pragma once
/// The figures of tests/report/STUDY.md#finite-difference-rule-finger_sign_change for one
/// trajectory and each renderer, with the proxy held: range of the force, theoretical, exact and
/// measured impedance, work per cycle. Unguarded, as the paper's.

#include <vector>

#include "tests/report/analysis/displayed_impedance.hpp"
#include "tests/report/analysis/finite_differences.hpp"
#include "tests/report/analysis/trajectory.hpp"

namespace haptic::core {

/// Forces in the unit of Z_q times that of q_a, impedances in that of Z_q.
struct TrajectoryMetrics {
  double tau_min{0.0}, tau_max{0.0};
  double theory_min{0.0}, theory_max{0.0};                ///< Eq. (2), (5), (9)
  double exact_partial_min{0.0}, exact_partial_max{0.0};  ///< d tau_a/dq_a; q_n and x fixed
  double exact_nonpassive_pct{0.0};                       ///< samples where it is > 0
  double fd_nonpassive_pct{0.0};
  double fd_excluded_pct{0.0};
  double fd_all_nonpassive_pct{0.0};
  double energy_weighted_pct{0.0};
  double cycle_work_pct{0.0};  ///< of the peak spring energy; positive: the device gave energy
  double cycle_work_reversed_pct{0.0};
  double running_energy_pct{0.0};  ///< lowest over one cycle from its first sample on
};

/// The same, sample by sample, for figures.
struct TrajectorySeries {
  std::vector<double> tau{};
  std::vector<double> theory{};
  std::vector<double> exact_partial{};
  std::vector<double> measured{};  ///< step i to i + 1; NaN where the rule leaves it out
};

class TrajectoryAnalysis {
 public:
  /// `kinematics` must outlive the analysis; `x`: the held proxy; `Z_q`: unit of force over that of
  /// q_a. Z_x = Z_q I / (mean of ||J_a|| over the samples)^2, paper section VI.C. Throws
  /// SceneError: not one actuated DoF, or a pose at which f has no value.
  TrajectoryAnalysis(const Kinematics& kinematics, Trajectory trajectory, const VecX& x, double Z_q,
                     const StepRule& rule = {});

  [[nodiscard]] const Trajectory& trajectory() const noexcept { return trajectory_; }
  /// Mean of ||J_a|| over the samples.
  [[nodiscard]] double mean_actuated_jacobian() const noexcept { return mean_J_a_; }
  /// V_peak = max 1/2 Z_q (q*_a - q_a)^2 with the q* of Eq. (6): the yardstick of every method.
  [[nodiscard]] double peak_energy() const noexcept { return peak_energy_; }

  [[nodiscard]] TrajectorySeries series(RendererKind kind) const;
  [[nodiscard]] TrajectoryMetrics metrics(RendererKind kind) const;

 private:
  /// Command of the renderer itself at each pose of the path.
  [[nodiscard]] std::vector<double> forces(RendererKind kind, const std::vector<VecQ>& path) const;
  [[nodiscard]] std::vector<double> actuated(const std::vector<VecQ>& path) const;
  /// d tau_a/dq_a by `evaluate` at each sample; throws where there is none.
  template <typename Evaluate>
  [[nodiscard]] std::vector<double> partials(const Evaluate& evaluate) const;

  const Kinematics* kinematics_;
  Trajectory trajectory_;
  VecX x_;
  StepRule rule_;
  RenderingImpedance impedance_{};
  double mean_J_a_{0.0};
  double peak_energy_{0.0};
};

}  // namespace haptic::core
