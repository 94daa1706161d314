/// haptic-report coupling: the force of an underactuated device against that of a fully actuated
/// one, by the metric in which the client projects its proxy (core/METHOD.md#anisotropic-coupling).
#include <algorithm>
#include <cmath>
#include <vector>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/report/chosen_linkage.hpp"
#include "tests/report/command.hpp"
#include "tests/report/coupling_equilibrium.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {
namespace {

struct Stop {
  const char* name{};
  Eigen::Vector2d normal;
};

/// The joints alone, both alike, and one that the PIP has the larger part in.
const std::vector<Stop>& stops() {
  static const std::vector<Stop> all{{"mcp", {1.0, 0.0}},
                                     {"pip", {0.0, 1.0}},
                                     {"oblique", {0.6, 0.8}},
                                     {"both", {std::sqrt(0.5), std::sqrt(0.5)}}};
  return all;
}

/// A metric of the client's: the identity, or the coupling metric of this softness.
struct Metric {
  const char* name{};
  std::optional<double> softness;
};
constexpr Metric kMetrics[] = {{"identity", std::nullopt},
                               {"eps_1", 1.0},
                               {"eps_0.1", 0.1},
                               {"eps_0.01", 0.01},
                               {"eps_0.001", 0.001}};

struct Scope {
  std::vector<Pair> poses{
      {30.0, 30.0}, {60.0, 70.0}, {10.0, 40.0}};  // core/METHOD.md#finger-linkage,
                                                  // and its corner
  std::vector<double> penetrations{1.0, 2.0, 5.0, 10.0, 15.0};
  std::vector<double> stiffnesses{1500.0, 6000.0};
};

const char* verdict_of(const Press& press, const Rest& full, const std::optional<Rest>& rest) {
  if (!rest) return "leaves the workspace";
  // Beyond where the finger meant to be: the 1e-6 is the rest's own accuracy.
  if (rest->penetration > (1.0 + 1e-6) * press.penetration) return "pulls in";
  return rest->tau_a * full.tau_a < 0.0 ? "opposite sign" : "ok";
}

void print(const core::Kinematics& finger, const Press& press, const Stop& stop, const Pair& pose) {
  const std::optional<Rest> full = full_device(finger, press);
  if (!full) throw core::SceneError("coupling: a pose is out of reach");
  for (const Metric& metric : kMetrics) {
    const std::optional<Rest> rest = underactuated(finger, press, metric.softness);
    const double nothing = std::nan("");
    const double error =
        rest ? std::abs(rest->tau_a - full->tau_a) / std::abs(full->tau_a) : nothing;
    const double depth = rest ? rest->penetration : nothing;
    row(pose.first, pose.second, stop.name, press.stiffness, press.penetration / kDegree,
        metric.name, metric.softness.value_or(nothing), full->tau_a, rest ? rest->tau_a : nothing,
        error, full->penetration / kDegree, depth / kDegree, verdict_of(press, *full, rest));
  }
}

void print_all(const Scope& scope) {
  row("pose_mcp_deg", "pose_pip_deg", "stop", "stiffness_n_per_m", "penetration_deg", "metric",
      "softness", "tau_full_n", "tau_n", "force_error", "end_full_deg", "end_deg", "verdict");
  const auto finger = core::make_finger_exoskeleton(chosen_linkage());
  for (const Pair& pose : scope.poses) {
    for (const Stop& stop : stops()) {
      for (const double stiffness : scope.stiffnesses) {
        for (const double penetration : scope.penetrations) {
          const Press press{{pose.first * kDegree, pose.second * kDegree},
                            stop.normal,
                            penetration * kDegree,
                            stiffness};
          print(*finger, press, stop, pose);
        }
      }
    }
  }
}

}  // namespace

void add_coupling(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "coupling",
      "Force of an underactuated device against a fully actuated one, by client metric");
  command->footer(
      "The finger means to be some way behind a plane in joint space and comes to rest. Force "
      "error: "
      "of the actuator, relative to its part in a device that drives both DoFs. Metric: identity, "
      "or "
      "the coupling metric of that softness (core/METHOD.md#anisotropic-coupling). end_deg: how "
      "deep the finger then is; "
      "beyond penetration_deg the force pulls it into the wall.");
  auto scope = std::make_shared<Scope>();
  command->add_option("--pose", scope->poses, "MCP_DEG,PIP_DEG on the plane; several")
      ->default_str("30,30 60,70 10,40");
  command->add_option("--penetration", scope->penetrations, "meant, deg; several")
      ->check(CLI::Range(0.01, 60.0))
      ->default_str("1 2 5 10 15");
  command->add_option("--stiffness", scope->stiffnesses, "Z_q, N/m; several")
      ->check(CLI::PositiveNumber)
      ->default_str("1500 6000");
  command->callback([scope] { print_all(*scope); });
}

}  // namespace haptic::report
