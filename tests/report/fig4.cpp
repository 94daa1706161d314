/// haptic-report fig4: the paper's Fig. 4 and the metrics of
/// tests/report/STUDY.md#finite-difference-rule-finger_sign_change for one trajectory of the
/// finger, with the proxy held at x = 0, Z_q = 1, forces in mm of l_x, unguarded.
#include <cmath>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/motion/motion_csv.hpp"
#include "tests/report/analysis/trajectory_metrics.hpp"
#include "tests/report/chosen_linkage.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {
namespace {

constexpr double kMm = 1e3;

struct Options {
  Pair amplitude_deg{35, 50};  // tests/report/STUDY.md#fig-4-finger_sign_change, trajectory A
  double phase_deg{15};
  std::string motion{};
  double noise_mm{0.0};
  bool series{false};
};

struct Path {
  core::Trajectory trajectory{};
  std::vector<double> time_s{};
};

Path from_motion(const core::Kinematics& finger, const std::string& file) {
  const hw::MotionTable table = hw::read_motion_csv(file, {hw::joint_angle_columns()});
  std::vector<core::VecX> x;
  std::vector<char> gap(table.time_s.size(), 0);
  for (std::size_t i = 0; i < table.time_s.size(); ++i) {
    x.push_back((core::VecX(2) << table.values[0][i], table.values[1][i]).finished());
    gap[i] = i > 0 && hw::is_gap(table.time_s[i - 1], table.time_s[i]) ? 1 : 0;
  }
  Path path{core::recorded(finger, std::move(x), std::move(gap)), table.time_s};
  std::fprintf(stderr,
               "fig4: the path is open; for the cycle figures it is closed by a straight line in "
               "joint space\n");
  if (path.trajectory.beyond_reach > 0) {
    std::fprintf(stderr,
                 "fig4: %d of %zu samples are beyond the exoskeleton's reach; the nearest "
                 "pose in reach stands for them\n",
                 path.trajectory.beyond_reach, table.time_s.size());
  }
  return path;
}

Path from_grasp(const core::Kinematics& finger, const Options& options) {
  core::GraspCycle grasp;
  grasp.A1 = options.amplitude_deg.first * kDegree;
  grasp.A2 = options.amplitude_deg.second * kDegree;
  grasp.psi = options.phase_deg * kDegree;
  Path path{core::sampled(finger, grasp), {}};
  for (std::size_t i = 0; i < path.trajectory.q.size(); ++i) {
    path.time_s.push_back(static_cast<double>(i) / grasp.sample_rate);
  }
  if (path.trajectory.beyond_reach > 0) {
    throw core::SceneError("fig4: amplitude " +
                           line_of(options.amplitude_deg.first, options.amplitude_deg.second).text +
                           " deg takes the finger beyond the exoskeleton's reach in " +
                           std::to_string(path.trajectory.beyond_reach) + " samples");
  }
  return path;
}

void print_metrics(const core::TrajectoryAnalysis& analysis) {
  row("method", "metric", "value");
  for (const core::RendererKind kind : kMethods) {
    const core::TrajectoryMetrics m = analysis.metrics(kind);
    const auto metric = [&](const char* name, double value) { row(core::name(kind), name, value); };
    metric("tau_min", kMm * m.tau_min);
    metric("tau_max", kMm * m.tau_max);
    metric("exact_partial_min", m.exact_partial_min);
    metric("exact_partial_max", m.exact_partial_max);
    metric("exact_nonpassive_pct", m.exact_nonpassive_pct);
    metric("fd_nonpassive_pct", m.fd_nonpassive_pct);
    metric("fd_excluded_pct", m.fd_excluded_pct);
    metric("fd_all_nonpassive_pct", m.fd_all_nonpassive_pct);
    metric("energy_weighted_pct", m.energy_weighted_pct);
    metric("cycle_work_pct", m.cycle_work_pct);
    metric("cycle_work_reversed_pct", m.cycle_work_reversed_pct);
    metric("running_energy_pct", m.running_energy_pct);
    metric("theory_min", m.theory_min);
    metric("theory_max", m.theory_max);
    metric("cycle_closed_by_line", analysis.trajectory().closed_by_line ? 1 : 0);
  }
}

void print_series(const core::TrajectoryAnalysis& analysis, const std::vector<double>& time_s) {
  const core::Trajectory& path = analysis.trajectory();
  row("method", "t_s", "q_o1_mcp_deg", "q_o2_pip_deg", "l_x_mm", "tau_mm", "theory",
      "exact_partial", "measured");
  for (const core::RendererKind kind : kMethods) {
    const core::TrajectorySeries s = analysis.series(kind);
    for (std::size_t i = 0; i < path.q.size(); ++i) {
      if (i < path.gap_before.size() && path.gap_before[i] != 0) {
        // Nothing was measured here: a line drawn through the rows must break.
        row(core::name(kind), time_s[i], NAN, NAN, NAN, NAN, NAN, NAN, NAN);
      }
      row(core::name(kind), time_s[i], path.x_probe[i][0] / kDegree, path.x_probe[i][1] / kDegree,
          kMm * path.q[i][0], kMm * s.tau[i], s.theory[i], s.exact_partial[i],
          i < s.measured.size() ? s.measured[i] : NAN);
    }
  }
}

void run(const Options& options) {
  const auto finger = core::make_finger_exoskeleton(chosen_linkage());
  Path path =
      options.motion.empty() ? from_grasp(*finger, options) : from_motion(*finger, options.motion);
  core::StepRule rule;
  rule.sigma_q = options.noise_mm / kMm;
  const core::TrajectoryAnalysis analysis(*finger, std::move(path.trajectory), core::VecX::Zero(2),
                                          1.0, rule);
  if (options.series) {
    print_series(analysis, path.time_s);
  } else {
    print_metrics(analysis);
  }
}

}  // namespace

void add_fig4(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("fig4", "The paper's Fig. 4 on one trajectory: method,metric,value");
  command->footer(
      "The proxy is held at x = 0, Z_q = 1, Z_x = I/mean(||J_a||)^2; forces in mm of l_x. No "
      "guard. Percentages of cycle work are of the peak spring energy of Eq. (6); positive: the "
      "device gave energy.");
  auto options = std::make_shared<Options>();
  CLI::Option* amplitude =
      add_pair(*command, "--amplitude", options->amplitude_deg, "A1_DEG,A2_DEG (35,50)");
  CLI::Option* phase = command->add_option("--phase", options->phase_deg, "PSI_DEG (15)");
  command->add_option("--motion", options->motion, "a recording: CSV of joint angles")
      ->check(CLI::ExistingFile)
      ->excludes(amplitude)
      ->excludes(phase);
  command
      ->add_option("--noise", options->noise_mm,
                   "standard deviation of l_x in mm: steps below 5 of them are left out")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--series", options->series, "every sample instead: what the plot is made of");
  command->callback([options] { run(*options); });
}

}  // namespace haptic::report
