/// haptic-report radius: how far the proxy may be from the probe before a method's exact displayed
/// impedance turns (core/METHOD.md#exact-derivatives), over the workspace of the finger
/// (core/METHOD.md#finger-linkage).
#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/report/analysis/passivity_radius.hpp"
#include "tests/report/chosen_linkage.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {
namespace {

struct Sample {
  core::VecQ q{};
  core::VecX x{};
};

/// A grid of steps by steps poses over the workspace, [0,80] x [0,90] deg, those in reach.
std::vector<Sample> workspace(const core::Kinematics& finger, int steps) {
  std::vector<Sample> samples;
  core::VecQ q = core::VecQ::Zero(2);
  for (int i = 0; i < steps; ++i) {
    for (int k = 0; k < steps; ++k) {
      core::VecX x(2);
      x << 80.0 * kDegree * (i + 0.5) / steps, 90.0 * kDegree * (k + 0.5) / steps;
      if (finger.inverse(x, q) == core::InverseStatus::kExact) samples.push_back({q, x});
    }
  }
  return samples;
}

std::vector<double> radii(const core::Kinematics& finger, const std::vector<Sample>& samples,
                          core::RendererKind kind) {
  const core::RenderingImpedance impedance{core::VecA::Ones(1), core::MatXX::Identity(2, 2)};
  std::vector<double> result;
  for (const Sample& at : samples) {
    const auto certificate = core::passivity_certificate(kind, finger, at.q, at.x, impedance);
    if (!certificate) throw core::SceneError("radius: a pose of the workspace has no impedance");
    result.push_back(certificate->radius / kDegree);
  }
  return result;
}

void print_quantiles(const core::Kinematics& finger, const std::vector<Sample>& samples,
                     const std::vector<core::RendererKind>& kinds) {
  row("method", "quantile_pct", "radius_deg", "poses");
  for (const core::RendererKind kind : kinds) {
    std::vector<double> sorted = radii(finger, samples, kind);
    std::sort(sorted.begin(), sorted.end());
    for (const double percent : {0, 1, 5, 25, 50, 75, 95, 99, 100}) {
      const double at = percent / 100.0 * static_cast<double>(sorted.size() - 1);
      row(core::name(kind), percent, sorted[static_cast<std::size_t>(std::lround(at))],
          sorted.size());
    }
  }
}

void print_map(const core::Kinematics& finger, const std::vector<Sample>& samples,
               const std::vector<core::RendererKind>& kinds) {
  row("method", "l_x_mm", "q_B_deg", "q_o1_mcp_deg", "q_o2_pip_deg", "radius_deg");
  for (const core::RendererKind kind : kinds) {
    const std::vector<double> values = radii(finger, samples, kind);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      row(core::name(kind), 1e3 * samples[i].q[0], samples[i].q[1] / kDegree,
          samples[i].x[0] / kDegree, samples[i].x[1] / kDegree, values[i]);
    }
  }
}

}  // namespace

void add_radius(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "radius", "Passivity radius of the linearised method over the workspace, quantiles");
  command->footer(
      "Within the radius (norm of dx in joint space) the exact d tau_a/dq_a is negative whatever "
      "the direction of dx. Necessary for passivity, not sufficient: see the cycle work of fig4.");
  struct Options {
    int steps{200};
    bool all{false}, map{false};
  };
  auto options = std::make_shared<Options>();
  command->add_option("--grid", options->steps, "poses per joint (200)")
      ->check(CLI::Range(2, 5000));
  command->add_flag("--all", options->all, "the standard and the null-space method as well");
  command->add_flag("--map", options->map, "every pose instead: what the plot is made of");
  command->callback([options] {
    std::vector<core::RendererKind> kinds{core::RendererKind::kSubspaceLinear};
    if (options->all) {
      kinds = {core::RendererKind::kStandard, core::RendererKind::kNullSpace,
               core::RendererKind::kSubspaceLinear};
    }
    const auto finger = core::make_finger_exoskeleton(chosen_linkage());
    const std::vector<Sample> samples = workspace(*finger, options->steps);
    if (samples.empty()) throw core::SceneError("radius: the grid has no pose in the workspace");
    (options->map ? print_map : print_quantiles)(*finger, samples, kinds);
  });
}

}  // namespace haptic::report
