#include "tests/report/analysis/trajectory_metrics.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "haptic/core/error.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "tests/report/analysis/cycle_energy.hpp"

namespace haptic::core {

TrajectoryAnalysis::TrajectoryAnalysis(const Kinematics& kinematics, Trajectory trajectory,
                                       const VecX& x, double Z_q, const StepRule& rule)
    : kinematics_(&kinematics), trajectory_(std::move(trajectory)), x_(x), rule_(rule) {
  const DofLayout& layout = kinematics.layout();
  if (layout.n_a() != 1) {
    throw SceneError("trajectory metrics with " + std::to_string(layout.n_a()) +
                     " actuated DoFs: must be 1 (the measured impedance is a quotient)");
  }
  double sum = 0.0;
  VecX x_probe;
  MatXQ J;
  for (const VecQ& q : trajectory_.q) {
    if (kinematics.evaluate(q, x_probe, J) != MapStatus::kOk) {
      throw SceneError("trajectory passes a pose that the device's map does not have");
    }
    sum += J.col(layout.actuated(0)).norm();
  }
  mean_J_a_ = sum / static_cast<double>(std::max<std::size_t>(trajectory_.q.size(), 1));
  const int n_x = kinematics.space().n_x();
  impedance_.Z_q = VecA::Constant(1, Z_q);
  impedance_.Z_x = MatXX::Identity(n_x, n_x) * (Z_q / (mean_J_a_ * mean_J_a_));
  for (const double tau : forces(RendererKind::kSubspaceExact, trajectory_.q)) {
    peak_energy_ = std::max(peak_energy_, 0.5 * tau * tau / Z_q);
  }
}

std::vector<double> TrajectoryAnalysis::forces(RendererKind kind,
                                               const std::vector<VecQ>& path) const {
  const bool baseline = kind == RendererKind::kStandard || kind == RendererKind::kNullSpace;
  // The renderer's own Z_x takes the mean over the workspace, the paper's that over the samples.
  const double workspace = kinematics_->mean_actuated_jacobian();
  const double scale = baseline ? workspace * workspace / (mean_J_a_ * mean_J_a_) : 1.0;
  const int actuated = kinematics_->layout().actuated(0);
  Renderer renderer(kind, *kinematics_);
  Projection out;
  VecX x_probe, dx(kinematics_->space().n_x());
  MatXQ J;
  std::vector<double> result;
  result.reserve(path.size());
  for (const VecQ& q : path) {
    if (kinematics_->evaluate(q, x_probe, J) != MapStatus::kOk) {
      throw SceneError("trajectory passes a pose that the device's map does not have");
    }
    kinematics_->space().difference(x_, x_probe, dx);
    renderer.project(Probe{q, x_probe, J}, x_, dx, impedance_.Z_q, result.empty(), out);
    result.push_back(scale * impedance_.Z_q[0] * (out.q_star[actuated] - q[actuated]));
  }
  return result;
}

std::vector<double> TrajectoryAnalysis::actuated(const std::vector<VecQ>& path) const {
  std::vector<double> result;
  result.reserve(path.size());
  for (const VecQ& q : path) result.push_back(q[kinematics_->layout().actuated(0)]);
  return result;
}

template <typename Evaluate>
std::vector<double> TrajectoryAnalysis::partials(const Evaluate& evaluate) const {
  std::vector<double> result;
  result.reserve(trajectory_.q.size());
  for (const VecQ& q : trajectory_.q) {
    const std::optional<MatAQ> impedance = evaluate(q);
    if (!impedance) throw SceneError("trajectory passes a pose without a displayed impedance");
    result.push_back((*impedance)(0, kinematics_->layout().actuated(0)));
  }
  return result;
}

TrajectorySeries TrajectoryAnalysis::series(RendererKind kind) const {
  TrajectorySeries result;
  result.tau = forces(kind, trajectory_.q);
  result.theory = partials(
      [&](const VecQ& q) { return theoretical_impedance(kind, *kinematics_, q, impedance_); });
  result.exact_partial = partials(
      [&](const VecQ& q) { return exact_impedance(kind, *kinematics_, q, x_, impedance_); });
  result.measured =
      finite_differences(actuated(trajectory_.q), result.tau, rule_, trajectory_.gap_before)
          .impedance;
  return result;
}

TrajectoryMetrics TrajectoryAnalysis::metrics(RendererKind kind) const {
  TrajectoryMetrics m;
  const TrajectorySeries all = series(kind);
  const auto range = [](const std::vector<double>& values, double& lowest, double& highest) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    lowest = *low;
    highest = *high;
  };
  range(all.tau, m.tau_min, m.tau_max);
  range(all.theory, m.theory_min, m.theory_max);
  range(all.exact_partial, m.exact_partial_min, m.exact_partial_max);
  const auto positive = std::count_if(all.exact_partial.begin(), all.exact_partial.end(),
                                      [](double partial) { return partial > 0.0; });
  m.exact_nonpassive_pct =
      100.0 * static_cast<double>(positive) / static_cast<double>(all.exact_partial.size());

  const FiniteDifferences fd =
      finite_differences(actuated(trajectory_.q), all.tau, rule_, trajectory_.gap_before);
  m.fd_nonpassive_pct = fd.nonpassive_pct;
  m.fd_excluded_pct = fd.excluded_pct;
  m.fd_all_nonpassive_pct = fd.all_nonpassive_pct;
  m.energy_weighted_pct = fd.energy_weighted_pct;

  std::vector<double> q_a = actuated(trajectory_.cycle);
  std::vector<double> tau = forces(kind, trajectory_.cycle);
  const double percent = peak_energy_ > 0.0 ? 100.0 / peak_energy_ : 0.0;
  m.cycle_work_pct = percent * cycle_work(q_a, tau);
  m.cycle_work_reversed_pct = percent * cycle_work(q_a, tau, Direction::kReversed);
  // Over the whole cycle: the step from the last sample back to the first is part of it.
  q_a.push_back(q_a.front());
  tau.push_back(tau.front());
  m.running_energy_pct = percent * lowest_running_energy(q_a, tau);
  return m;
}

}  // namespace haptic::core
