/// haptic-report linkage: what the finger's linkages are worth, and the search that chose the
/// default one (tests/report/STUDY.md#choice-of-the-linkage).
#include <cmath>

#include "hw/motion/motion_csv.hpp"
#include "tests/report/analysis/differential_evolution.hpp"
#include "tests/report/analysis/linkage_quality.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {
namespace {

constexpr double kMm = 1e3;
constexpr double kPercent = 1e2;
constexpr double kSearchStep = 5.0, kFineStep = 1.0;  // deg

struct Options {
  bool map{false};
  bool trade{false};
  std::vector<std::string> motions{};
  core::Evolution evolution{};
};

struct Named {
  const char* name;
  core::FingerDimensions dimensions;
};

std::vector<Named> linkages() {
  return {{"finger_same_sign", {}}, {"finger_sign_change", core::finger_sign_change()}};
}

// The search. A design is (distance of the rail from the MCP axis, gamma, d, e_x, e_y, h1, h2): the
// origin along the rail and the zero of q_B change nothing but the names of l_x and q_B.

const std::vector<core::Interval> kDesigns{{-0.06, 0.06}, {-M_PI, M_PI}, {0.005, 0.06},
                                           {-0.13, 0.13}, {-0.13, 0.13}, {0.010, 0.026},
                                           {0.010, 0.026}};

core::FingerDimensions dimensions_of(const std::vector<double>& design) {
  core::FingerDimensions d;
  d.rail_origin = {-design[0] * std::sin(design[1]), design[0] * std::cos(design[1])};
  d.rail_angle = design[1];
  d.body_d = {design[2], 0.0};
  d.body_e = {design[3], design[4]};
  d.rod1 = design[5];
  d.rod2 = design[6];
  d.slider1_upper = 0.046;  // as long as the phalanges
  d.slider2_upper = 0.040;
  d.l_x_lower = -0.2;  // the search finds the range
  d.l_x_upper = 0.2;
  d.q_B_lower = -M_PI;
  d.q_B_upper = M_PI;
  return d;
}

constexpr double kLongestStroke = 0.048;  // m: of the 50 of the actuator
constexpr double kWorstCondition = 30.0;  // finger_sign_change has 36
constexpr double kEnoughLeast = 0.020;    // m/rad: more of the least w is not looked for

/// The less the better. The weights order the wishes: reach, then what the mechanism allows, then
/// the sign, the share above 5 mm/rad and the least w.
double cost(const core::FingerDimensions& dimensions, double lowest_pivot) {
  const core::LinkageQuality q = core::linkage_quality(dimensions, kSearchStep);
  if (q.reach == 0.0) return 1e4;
  const double least = std::min(std::min(q.w1.lowest, q.w2.lowest), kEnoughLeast);
  return 1000.0 * (1.0 - q.with_straight) + 20.0 * kMm * std::max(0.0, q.stroke - kLongestStroke) +
         10.0 * kMm * std::max(0.0, lowest_pivot - q.pivot_height.lowest) +
         2.0 * std::max(0.0, q.condition.highest - kWorstCondition) +
         100.0 * (1.0 - q.both_positive) + 50.0 * (1.0 - q.both_strong) -
         2.0 * kMm * std::max(least, -0.1);
}

void print_heading() {
  row("linkage", "lowest_pivot_allowed_mm", "lowest_pivot_mm", "reach_pct",
      "reach_with_straight_pct", "both_positive_pct", "both_5mm_pct", "least_w_mcp_mm_per_rad",
      "least_w_pip_mm_per_rad", "condition_median", "condition_largest", "stroke_mm", "c1_from_mm",
      "c1_to_mm", "c2_from_mm", "c2_to_mm", "felt_mcp_nm_per_rad", "felt_pip_nm_per_rad",
      "rail_x_mm", "rail_y_mm", "rail_deg", "d_mm", "e_x_mm", "e_y_mm", "h1_mm", "h2_mm");
}

void print_quality(const char* name, const core::FingerDimensions& d, double allowed) {
  const core::LinkageQuality q = core::linkage_quality(d, kFineStep);
  row(name, kMm * allowed, kMm * q.pivot_height.lowest, kPercent * q.reach,
      kPercent * q.with_straight, kPercent * q.both_positive, kPercent * q.both_strong,
      kMm * q.w1.lowest, kMm * q.w2.lowest, q.median_condition, q.condition.highest, kMm * q.stroke,
      kMm * q.c1.lowest, kMm * q.c1.highest, kMm * q.c2.lowest, kMm * q.c2.highest,
      q.median_felt_mcp, q.median_felt_pip, kMm * d.rail_origin.x, kMm * d.rail_origin.y,
      d.rail_angle / kDegree, kMm * d.body_d.x, kMm * d.body_e.x, kMm * d.body_e.y, kMm * d.rod1,
      kMm * d.rod2);
}

void print_trade(const core::Evolution& evolution) {
  for (const double allowed :
       {0.010, 0.006, 0.003, 0.0, -0.002, -0.004, -0.006, -0.008, -0.010, -0.012, -0.015}) {
    const std::vector<double> best =
        core::minimise([&](const auto& design) { return cost(dimensions_of(design), allowed); },
                       kDesigns, evolution);
    print_quality("search", dimensions_of(best), allowed);
  }
}

void print_map() {
  row("linkage", "mcp_deg", "pip_deg", "w_mcp_mm_per_rad", "w_pip_mm_per_rad", "condition");
  for (const Named& one : linkages()) {
    for (int mcp = -20; mcp <= 90; ++mcp) {
      for (int pip = -10; pip <= 110; ++pip) {
        const auto node = core::linkage_node(one.dimensions, mcp * kDegree, pip * kDegree);
        row(one.name, mcp, pip, node ? kMm * node->w1 : NAN, node ? kMm * node->w2 : NAN,
            node ? node->condition : NAN);
      }
    }
  }
}

void print_motions(const std::vector<std::string>& files) {
  row("linkage", "recording", "samples", "in_workspace_pct", "reached_pct", "both_positive_pct",
      "least_w_mcp_mm_per_rad", "least_w_pip_mm_per_rad");
  for (const Named& one : linkages()) {
    for (const std::string& file : files) {
      const hw::MotionTable table = hw::read_motion_csv(file, {hw::joint_angle_columns()});
      const std::size_t samples = table.time_s.size();
      int inside = 0, reached = 0, positive = 0;
      core::Range w1, w2;
      for (std::size_t i = 0; i < samples; ++i) {
        const double mcp = table.values[0][i], pip = table.values[1][i];
        inside += mcp >= 0.0 && mcp <= 80 * kDegree && pip >= 0.0 && pip <= 90 * kDegree ? 1 : 0;
        const auto node = core::linkage_node(one.dimensions, mcp, pip);
        if (!node) continue;
        ++reached;
        positive += node->w1 > 0.0 && node->w2 > 0.0 ? 1 : 0;
        w1.add(node->w1);
        w2.add(node->w2);
      }
      const auto share = [](int part, std::size_t of) {
        return kPercent * part / static_cast<double>(of);
      };
      row(one.name, file.substr(file.rfind('/') + 1), samples, share(inside, samples),
          share(reached, samples), share(positive, static_cast<std::size_t>(std::max(reached, 1))),
          kMm * w1.lowest, kMm * w2.lowest);
    }
  }
}

void run(const Options& options) {
  if (options.map) return print_map();
  if (!options.motions.empty()) return print_motions(options.motions);
  print_heading();
  for (const Named& one : linkages()) print_quality(one.name, one.dimensions, NAN);
  if (options.trade) print_trade(options.evolution);
}

}  // namespace

void add_linkage(CLI::App& app) {
  CLI::App* command = app.add_subcommand("linkage", "What the finger's linkages are worth");
  command->footer(
      "Over [0,80] x [0,90] deg in steps of one degree. w: torque at the joint per N at the "
      "actuator. `straight` adds [-15,0] x [0,70] deg. felt: w Z w^T at 1500 N/m, median.");
  auto options = std::make_shared<Options>();
  auto* map = command->add_flag("--map", options->map, "w and condition, degree by degree");
  auto* trade = command->add_flag("--trade", options->trade,
                                  "also the best linkages of a search, by the lowest place that "
                                  "the carriage's pivot may take over the MCP axis; minutes");
  command->add_option("--motion", options->motions, "recordings: share with both signs right")
      ->check(CLI::ExistingFile)
      ->excludes(map)
      ->excludes(trade);
  command->add_option("--seed", options->evolution.seed, "of the search (1)")->needs(trade);
  command->add_option("--generations", options->evolution.generations, "of the search (700)")
      ->needs(trade)
      ->check(CLI::Range(1, 100000));
  command->callback([options] { run(*options); });
}

}  // namespace haptic::report
