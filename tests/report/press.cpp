/// haptic-report press: random presses, what the finger feels of them, and what of it is not as it
/// should be (tests/report/STUDY.md#presses).
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

#include "haptic/core/error.hpp"
#include "tests/report/chosen_linkage.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/press_study.hpp"
#include "tests/support/percentile.hpp"

namespace haptic::report {
namespace {

constexpr double kDeeper_deg = 0.5;      // at the end, beyond the press without force
constexpr double kDeeperPeak_deg = 1.0;  // at any time
constexpr double kWeak = 0.3;            // of the running peak
constexpr double kRounding = 1e-9;       // J
constexpr std::uint64_t kSeed = 19;
constexpr std::size_t kAllClients = 99;

struct Options {
  std::string method{}, noise{};
  int presses{640}, only{-1};
  std::uint64_t seed{kSeed};
  double stiffness{0.0};
  std::string summary{};  ///< file
  bool unguarded{false}, no_tank{false}, strict_tank{false}, trace{false};
};

/// One press by one renderer, next to the same without force.
struct Pressed {
  RandomPress press{};
  PressFigures without{}, with{};
  double tank{0.0};  ///< tank_0, J
  double untanked_most_given{0.0};
  double deeper_deg{0.0}, deeper_peak_deg{0.0};
  bool spared{true};  ///< throttled only if the running output without a tank exceeds it
};

PressRun run_of(const RandomPress& press, core::RendererKind kind, const Options& options) {
  PressRun how{kind, true, !options.unguarded, {}, sensor_noise(options.noise)};
  if (!options.no_tank) how.tank = options.strict_tank ? 0.0 : default_tank(press);
  return how;
}

std::vector<core::RendererKind> methods(const Options& options) {
  std::vector<core::RendererKind> all(core::kRenderers.begin(), core::kRenderers.end());
  std::erase_if(all, [&](auto kind) { return !chosen(options.method, core::name(kind)); });
  return all;
}

Pressed pressed(const RandomPress& press, const PressFigures& without, core::RendererKind kind,
                const Options& options, const std::shared_ptr<const core::Kinematics>& finger) {
  Pressed out{press, without};
  PressRun how = run_of(press, kind, options);
  out.tank = how.tank.value_or(0.0);
  out.with = run(press, how, finger);
  out.deeper_deg = out.deeper_peak_deg = -1e9;
  for (int i = 0; i < press.planes.size(); ++i) {
    const double end = std::max(out.with.end_deg[i], 0.0) - std::max(without.end_deg[i], 0.0);
    out.deeper_deg = std::max(out.deeper_deg, end);
    out.deeper_peak_deg = std::max(out.deeper_peak_deg, out.with.peak_deg[i] - without.peak_deg[i]);
  }
  out.untanked_most_given = out.with.most_given;
  if (out.with.throttled > 0) {
    how.tank.reset();
    out.untanked_most_given = run(press, how, finger).most_given;
    out.spared = out.untanked_most_given > out.tank + kRounding;
  }
  return out;
}

void print_each(const Pressed& p, core::RendererKind kind, const std::string& linkage) {
  const Pair depth_end{p.with.end_deg[0], p.press.planes.size() > 1 ? p.with.end_deg[1] : 0.0};
  const Pair depth_without{p.without.end_deg[0],
                           p.press.planes.size() > 1 ? p.without.end_deg[1] : 0.0};
  row(linkage, core::name(kind), p.press.index, name(p.press.walls),
      kPressClients[p.press.client].name, p.press.stiffness, p.press.rise_s, p.press.aim_deg.first,
      p.press.aim_deg.second, depth_without.first, depth_without.second, depth_end.first,
      depth_end.second, p.deeper_deg, p.deeper_peak_deg, p.with.end_force, p.with.peak_force,
      p.with.throttled, p.spared ? 0 : p.with.throttled, p.with.limited, p.with.contact,
      p.with.judged, p.with.off, p.with.unrenderable, p.with.weakest, p.with.ripple,
      p.with.pushed_in, 1e3 * p.with.given, 1e3 * p.with.most_given, 1e3 * p.with.most_net,
      1e3 * p.untanked_most_given, p.with.throttled_step, 1e3 * p.with.band);
}

/// Counts of all presses by one renderer.
struct Count {
  int presses{0}, deeper{0}, deeper_peak{0}, throttled{0}, not_spared{0}, weak{0}, weak_of{0},
      weak_unthrottled{0}, ripple{0}, over_tank{0}, in_vain{0};
  long contact{0}, limited{0}, judged{0}, off{0}, unrenderable{0}, pushed_in{0};
  double worst_deg{-1e9}, worst_peak_deg{-1e9}, worst_net{0.0};
  std::vector<double> band{};    ///< N
  std::vector<double> relief{};  ///< share of the depth without force that the force took away

  void add(const Pressed& p) {
    ++presses;
    deeper += p.deeper_deg > kDeeper_deg;
    deeper_peak += p.deeper_peak_deg > kDeeperPeak_deg;
    worst_deg = std::max(worst_deg, p.deeper_deg);
    worst_peak_deg = std::max(worst_peak_deg, p.deeper_peak_deg);
    throttled += p.with.throttled > 0;
    not_spared += !p.spared;
    if (p.press.planes.size() == 1) {
      ++weak_of;
      weak += p.with.weakest < kWeak;
      weak_unthrottled += p.with.weakest < kWeak && p.with.throttled == 0;
    }
    ripple += p.with.ripple > 0.2;
    over_tank += p.with.most_net > p.tank + 1e-6;
    worst_net = std::max(worst_net, p.with.most_net - p.tank);
    band.push_back(p.with.band);
    contact += p.with.contact;
    limited += p.with.limited;
    judged += p.with.judged;
    off += p.with.off;
    unrenderable += p.with.unrenderable;
    pushed_in += p.with.pushed_in;
    double before = 0.0, after = 0.0;
    for (int i = 0; i < p.press.planes.size(); ++i) {
      before += std::max(p.without.end_deg[i], 0.0);
      after += std::max(p.with.end_deg[i], 0.0);
    }
    relief.push_back(1.0 - after / before);
    in_vain += 1.0 - after / before < 0.01;
  }
};

double percent(double part, double whole) {
  return whole > 0.0 ? 100.0 * part / whole : 0.0;
}

Line summary_of(const std::string& linkage, std::string_view method, std::string_view client,
                const Count& c) {
  return line_of(linkage, method, client, c.presses, c.deeper, c.worst_deg, c.deeper_peak,
                 c.worst_peak_deg, c.throttled, c.not_spared, c.weak, c.weak_unthrottled, c.weak_of,
                 percent(static_cast<double>(c.off), static_cast<double>(c.judged)),
                 percent(static_cast<double>(c.limited), static_cast<double>(c.contact)),
                 percent(static_cast<double>(c.unrenderable), static_cast<double>(c.contact)),
                 c.pushed_in, c.over_tank, 1e3 * c.worst_net, c.ripple,
                 percent(test::percentile(c.relief, 0.5), 1.0), c.in_vain,
                 1e3 * test::percentile(c.band, 0.95));
}

/// Throws SceneError if the file cannot be written.
void write_summary(const std::string& path, const std::vector<Line>& lines) {
  std::ofstream file(path);
  file << "linkage,method,client,presses,deeper,deepest_deg,deeper_at_peak,deepest_at_peak_deg,"
          "throttled,throttled_though_passive,weakening,weakening_unthrottled,weakening_of,off_pct,"
          "limited_pct,unrenderable_pct,pushed_in_ticks,over_tank,most_net_mj,rippling,"
          "median_relief_pct,in_vain,band_95_mn\n";
  for (const Line& line : lines) file << line.text << '\n';
  if (!file.flush()) throw core::SceneError("press: cannot write " + path);
}

void print(const Options& options) {
  const std::shared_ptr<const core::Kinematics> finger =
      core::make_finger_exoskeleton(chosen_linkage());
  row("linkage", "method", "press", "walls", "client", "stiffness_n_per_m", "rise_s", "aim_mcp_deg",
      "aim_pip_deg", "without_1_deg", "without_2_deg", "end_1_deg", "end_2_deg", "deeper_deg",
      "deeper_peak_deg", "end_force_n", "peak_force_n", "throttled_ticks",
      "throttled_though_passive_ticks", "limited_ticks", "contact_ticks", "judged_ticks",
      "off_ticks", "unrenderable_ticks", "weakest", "ripple_n", "pushed_in_ticks", "given_mj",
      "most_given_mj", "most_net_mj", "untanked_most_given_mj", "throttled_step_n", "band_mn");
  const std::vector<core::RendererKind> kinds = methods(options);
  std::map<std::pair<std::size_t, std::size_t>, Count> counts;
  for (int i = 0; i < options.presses; ++i) {
    if (options.only >= 0 && i != options.only) continue;
    RandomPress press = random_press(options.seed, i, *finger);
    if (options.stiffness > 0.0) press.stiffness = options.stiffness;
    const PressFigures without =
        run(press, {core::RendererKind::kSubspaceLinear, false, false, false}, finger);
    for (std::size_t k = 0; k < kinds.size(); ++k) {
      const Pressed p = pressed(press, without, kinds[k], options, finger);
      print_each(p, kinds[k], chosen_linkage_name());
      counts[{k, press.client}].add(p);
      counts[{k, kAllClients}].add(p);
    }
  }
  if (options.summary.empty()) return;
  std::vector<Line> lines;
  for (const auto& [key, count] : counts) {
    const std::string_view client =
        key.second == kAllClients ? "all" : kPressClients[key.second].name;
    lines.push_back(summary_of(chosen_linkage_name(), core::name(kinds[key.first]), client, count));
  }
  write_summary(options.summary, lines);
}

void print_trace(const Options& options) {
  const std::shared_ptr<const core::Kinematics> finger =
      core::make_finger_exoskeleton(chosen_linkage());
  RandomPress press = random_press(options.seed, std::max(options.only, 0), *finger);
  if (options.stiffness > 0.0) press.stiffness = options.stiffness;
  row("linkage", "method", "press", "t_s", "mcp_deg", "pip_deg", "depth_1_deg", "depth_2_deg",
      "force_n", "optimum_n", "away_1_mm", "away_2_mm", "given_mj", "limiters");
  for (const core::RendererKind kind : methods(options)) {
    const PressRun how = run_of(press, kind, options);
    static_cast<void>(run(press, how, finger, [&](const PressStudyTick& tick) {
      row(chosen_linkage_name(), core::name(kind), press.index, tick.t_s, tick.x_deg.first,
          tick.x_deg.second, tick.depth_deg[0], tick.depth_deg[1], tick.tau_a, tick.optimum,
          1e3 * tick.away[0], 1e3 * tick.away[1], 1e3 * tick.given, tick.limiters.bits());
    }));
  }
}

}  // namespace

void add_press(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "press", "Random presses: what the finger feels against the best possible");
  command->footer(
      "A press: the hand goes to its aim and stays, one or two walls in the way; every fourth "
      "press "
      "has the same client. deeper: at the end beyond a wall by 0.5 deg more than without force; "
      "at_peak: by 1 deg at any time. throttled_though_passive: by the tank, though without it the "
      "running output never exceeds what it holds. weakening: below 30 % of the running peak while "
      "depth grows, one wall, lever above 2 mm/rad. off: felt torque more than 10 % off the best "
      "possible, deeper than 0.5 deg, no limiter. in_vain: less than 1 % of the depth taken away.");
  auto options = std::make_shared<Options>();
  command->add_option("--presses", options->presses, "how many (640)")->check(CLI::PositiveNumber);
  command->add_option("--seed", options->seed, "of the random presses");
  command->add_option("--method", options->method, "this renderer alone");
  add_noise(*command, options->noise, "of the sensors (none)");
  command->add_option("--stiffness", options->stiffness, "Z_q in N/m (500 to 6000, random)");
  command->add_option("--press", options->only, "this press alone, by its number");
  command->add_flag("--unguarded", options->unguarded, "without the direction guard");
  command->add_flag("--no-tank", options->no_tank, "without the energy tank");
  command->add_flag("--strict-tank", options->strict_tank,
                    "a tank that begins empty, instead of that of a scene which names none");
  command->add_option("--summary", options->summary, "file for the counts per renderer and client");
  command->add_flag("--trace", options->trace, "every tick of one press");
  command->callback([options] { (options->trace ? print_trace : print)(*options); });
}

}  // namespace haptic::report
