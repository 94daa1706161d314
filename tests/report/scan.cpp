/// haptic-report scan: the 168 trajectories of
/// tests/report/STUDY.md#finite-difference-rule-finger_sign_change; in how many of them does the
/// paper's finite-difference test find any sample that is not passive?
#include <algorithm>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/report/analysis/trajectory_metrics.hpp"
#include "tests/report/chosen_linkage.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {
namespace {

struct Case {
  core::GraspCycle grasp{};
  std::array<core::TrajectoryMetrics, kMethods.size()> metrics{};
  [[nodiscard]] bool active(std::size_t method) const {
    return metrics[method].fd_nonpassive_pct > 0.0;
  }
};

std::vector<Case> all_cases(const core::Kinematics& finger) {
  std::vector<Case> cases;
  for (const Pair& offset : {Pair{4, 4}, Pair{15, 10}}) {
    for (const double A1 : {20, 35, 56}) {
      for (const double A2 : {15, 30, 50, 70}) {
        for (const double psi : {0, 5, 10, 15, 25, 40, 60}) {
          Case one;
          one.grasp = {A1 * kDegree, A2 * kDegree, psi * kDegree, offset.first * kDegree,
                       offset.second * kDegree};
          one.grasp.sample_rate = 200.0;
          one.grasp.cycles = 1;
          const core::TrajectoryAnalysis analysis(finger, core::sampled(finger, one.grasp),
                                                  core::VecX::Zero(2), 1.0);
          for (std::size_t m = 0; m < kMethods.size(); ++m) {
            one.metrics[m] = analysis.metrics(kMethods[m]);
          }
          cases.push_back(one);
        }
      }
    }
  }
  return cases;
}

void print_shares(const std::vector<Case>& cases) {
  row("method", "trajectories", "any_nonpassive", "share_pct", "worst_cycle_work_pct");
  for (std::size_t m = 0; m < kMethods.size(); ++m) {
    int active = 0;
    double worst = 0.0;
    for (const Case& one : cases) {
      active += one.active(m) ? 1 : 0;
      // Whichever way the cycle is run: the user chooses.
      worst =
          std::max({worst, one.metrics[m].cycle_work_pct, one.metrics[m].cycle_work_reversed_pct});
    }
    row(core::name(kMethods[m]), cases.size(), active,
        100.0 * active / static_cast<double>(cases.size()), worst);
  }
}

void print_list(const std::vector<Case>& cases) {
  row("method", "a1_deg", "a2_deg", "psi_deg", "offset1_deg", "offset2_deg", "fd_nonpassive_pct",
      "fd_all_nonpassive_pct", "exact_nonpassive_pct", "cycle_work_pct");
  for (std::size_t m = 0; m < kMethods.size(); ++m) {
    for (const Case& one : cases) {
      const core::GraspCycle& g = one.grasp;
      const core::TrajectoryMetrics& metrics = one.metrics[m];
      row(core::name(kMethods[m]), g.A1 / kDegree, g.A2 / kDegree, g.psi / kDegree,
          g.offset1 / kDegree, g.offset2 / kDegree, metrics.fd_nonpassive_pct,
          metrics.fd_all_nonpassive_pct, metrics.exact_nonpassive_pct, metrics.cycle_work_pct);
    }
  }
}

}  // namespace

void add_scan(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("scan", "168 trajectories: share with any non-passive sample, per method");
  command->footer(
      "A1 20, 35, 56; A2 15, 30, 50, 70; psi 0..60 deg; offsets (4,4) and (15,10) deg; 200 Hz, one "
      "cycle; x = 0 held; unguarded. A sample counts as in fig4 --amplitude: |dq_a| > 10 % rms.");
  auto list = std::make_shared<bool>(false);
  command->add_flag("--list", *list, "every trajectory with its figures instead");
  command->callback([list] {
    const auto finger = core::make_finger_exoskeleton(chosen_linkage());
    const std::vector<Case> cases = all_cases(*finger);
    if (*list) {
      print_list(cases);
    } else {
      print_shares(cases);
    }
  });
}

}  // namespace haptic::report
