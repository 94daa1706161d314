/// haptic-report felt: speed against error of the whole system (tests/report/STUDY.md#felt-torque):
/// how far off is the torque at the finger, by renderer, proxy, rate and delay; what a tick costs.
#include <algorithm>
#include <cmath>
#include <optional>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/report/bootstrap.hpp"
#include "tests/report/chosen_linkage.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/felt_study.hpp"
#include "tests/support/percentile.hpp"

namespace haptic::report {
namespace {

constexpr std::uint64_t kSeed = 19;
constexpr int kTurns = 24;  // of timing
constexpr double kMilli = 1e3;

struct Options {
  std::vector<std::string> motions{};
  std::string method{}, proxy{}, noise{};
  std::optional<double> rate{}, delay{};
  int trajectories{200};
};

double percent(double part, double whole) {
  return whole > 0.0 ? 100.0 * part / whole : NAN;
}
/// Root mean square of torques in N mm, and one sum of squares in % of another.
double rms_nmm(double sum2, long ticks) {
  return ticks > 0 ? kMilli * std::sqrt(sum2 / static_cast<double>(ticks)) : NAN;
}
double rms_percent(double part2, double whole2) {
  return whole2 > 0.0 ? 100.0 * std::sqrt(part2 / whole2) : NAN;
}

/// One renderer under one client: a run per trajectory, and what a tick costs.
struct Cell {
  FeltRun how{};
  std::vector<FeltSums> sums{};      ///< by trajectory
  std::vector<FeltInputs> inputs{};  ///< of the first flat and the first round one
  std::vector<double> ns{};          ///< by turn
};

/// Every rate and delay; with an option that one network.
std::vector<Network> networks(const Options& options) {
  if (options.rate || options.delay) {
    return {{options.rate.value_or(60.0), options.delay.value_or(0.0) / kMilli}};
  }
  std::vector<Network> all;
  for (const double rate : {1000.0, 200.0, 60.0, 30.0}) {
    for (const double delay : {0.0, 0.020, 0.050, 0.100}) all.push_back({rate, delay});
  }
  return all;
}

/// All renderers at 60 Hz and 20 ms, or with an option; else the scene's own.
std::vector<Cell> cells(const Options& options, const Network& network) {
  const bool compared = options.rate || options.delay || !options.method.empty() ||
                        (network.rate_hz == 60.0 && network.delay_s == 0.020);
  std::vector<Cell> all;
  for (const ClientKind kind : kOfferedClients) {
    if (!chosen(options.proxy, name(kind))) continue;
    for (const core::RendererKind renderer : core::kRenderers) {
      if (!compared && renderer != core::RendererKind::kPerContact) continue;
      if (!chosen(options.method, core::name(renderer))) continue;
      all.push_back({{renderer, kind, network, sensor_noise(options.noise)}});
    }
  }
  return all;
}

void run_all(const FeltMotions& motions, const FeltDevice& device, Cell& cell) {
  constexpr std::size_t kTimed = 2;
  for (const FeltTrajectory& trajectory : motions.trajectories) {
    const bool timed = cell.inputs.size() < kTimed;
    if (timed) cell.inputs.emplace_back();
    cell.sums.push_back(run(trajectory, device, cell.how, timed ? &cell.inputs.back() : nullptr));
  }
}

/// Turn by turn, so that a slow turn of the machine is one for every cell.
void time_all(const FeltDevice& device, std::vector<Cell>& cells) {
  for (int turn = 0; turn < kTurns; ++turn) {
    for (Cell& cell : cells) {
      double ns = 0.0;
      for (const FeltInputs& inputs : cell.inputs) {
        ns += replayed_tick_ns(device, cell.how.renderer, inputs);
      }
      cell.ns.push_back(ns / static_cast<double>(cell.inputs.size()));
    }
  }
  for (Cell& cell : cells) cell.inputs.clear();
}

double median_at(const std::vector<double>& values, const std::vector<std::size_t>& index) {
  std::vector<double> sample;
  for (const std::size_t i : index) sample.push_back(values[i]);
  return test::percentile(sample, 0.5);
}

void print(const FeltMotions& motions, const Cell& cell, const std::string& of,
           const std::function<bool(const FeltTrajectory&)>& counts) {
  // A motion's trajectories stay together: they are not independent.
  std::vector<FeltSums> by_motion;
  int last = -1, trajectories = 0;
  for (std::size_t i = 0; i < cell.sums.size(); ++i) {
    const FeltTrajectory& trajectory = motions.trajectories[i];
    if (!counts(trajectory)) continue;
    if (trajectory.motion != last) by_motion.emplace_back();
    last = trajectory.motion;
    by_motion.back() += cell.sums[i];
    ++trajectories;
  }
  if (by_motion.empty()) return;
  const auto sum_at = [&](const std::vector<std::size_t>& index) {
    FeltSums sum;
    for (const std::size_t i : index) sum += by_motion[i];
    return sum;
  };
  const auto interval = [&](const auto& figure) {
    return interval_of(by_motion.size(), [&](const std::vector<std::size_t>& index) {
      return figure(sum_at(index));
    });
  };
  const auto share = [](long part, const FeltSums& sums) {
    return percent(static_cast<double>(part), static_cast<double>(sums.ticks));
  };
  FeltSums all;
  for (const FeltSums& one : by_motion) all += one;
  row(core::name(cell.how.renderer), name(cell.how.client), cell.how.network.rate_hz,
      cell.how.network.delay_s * kMilli, of, by_motion.size(), trajectories,
      rms_nmm(all.ideal2, all.ticks - all.limited),
      interval([](const FeltSums& s) { return rms_nmm(s.error2, s.ticks - s.limited); }),
      interval([](const FeltSums& s) { return rms_percent(s.error2, s.ideal2); }),
      interval([](const FeltSums& s) { return rms_percent(s.over2, s.best2); }),
      interval([](const FeltSums& s) { return rms_percent(s.all2, s.ideal_all2); }),
      interval([&](const FeltSums& s) { return share(s.limited, s); }), share(all.throttled, all),
      share(all.guarded, all), kMilli * std::sqrt(all.band2 / static_cast<double>(all.ticks)),
      all.ended, interval_of(cell.ns.size(), [&](const std::vector<std::size_t>& index) {
        return median_at(cell.ns, index);
      }));
}

void print_all(const Options& options) {
  const std::shared_ptr<const core::Kinematics> finger =
      core::make_finger_exoskeleton(chosen_linkage());
  const FeltDevice device = felt_device(finger);
  const FeltMotions motions = felt_motions(*finger, options.motions, options.trajectories, kSeed);
  std::fprintf(stderr,
               "felt: %zu trajectories of %d recorded motions and %d of the project's own making; "
               "%d windows of the recordings left out (a gap, out of reach or too small)\n",
               motions.trajectories.size(), motions.recorded_motions, motions.made_motions,
               motions.left_out);
  row("method", "proxy", "rate_hz", "delay_ms", "of", "motions", "trajectories", "ideal_nmm",
      "error_nmm", "error_lower_nmm", "error_upper_nmm", "error_pct", "error_lower_pct",
      "error_upper_pct", "over_best_pct", "over_best_lower_pct", "over_best_upper_pct",
      "error_all_ticks_pct", "error_all_ticks_lower_pct", "error_all_ticks_upper_pct",
      "limited_pct", "limited_lower_pct", "limited_upper_pct", "throttled_pct", "guarded_pct",
      "band_mn", "ended", "tick_ns", "tick_lower_ns", "tick_upper_ns");
  for (const Network& network : networks(options)) {
    std::vector<Cell> row_of_cells = cells(options, network);
    for (Cell& cell : row_of_cells) run_all(motions, device, cell);
    time_all(device, row_of_cells);
    for (const Cell& cell : row_of_cells) {
      print(motions, cell, "all", [](const FeltTrajectory&) { return true; });
      print(motions, cell, "recorded", [](const FeltTrajectory& t) { return t.recorded; });
      print(motions, cell, "made", [](const FeltTrajectory& t) { return !t.recorded; });
      print(motions, cell, "flat", [](const FeltTrajectory& t) { return !t.round; });
      print(motions, cell, "round", [](const FeltTrajectory& t) { return t.round; });
    }
    std::fflush(stdout);
  }
}

}  // namespace

void add_felt(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("felt", "Felt torque behind a slow or late client, and what a tick costs");
  command->footer(
      "A worn finger follows a hand's motion of 1.5 s into an object: one or two walls (flat) or a "
      "disc in joint space (round). Pipeline of the scene finger_soft_grasp, its tank empty at "
      "first, virtual time. error: "
      "rms over the ticks of the torque at both joints less that of a client at 1 kHz without "
      "delay that sends planes, at the same pose, same renderer and safeguards, no filters against "
      "noise; _pct: of the rms of the latter. 0 ms: used in the next tick. "
      "over_best: the same less the best torque that the device can give there. Ticks in which a "
      "limiter acted are left out of both and are limited_pct (throttled_pct: the tank, "
      "guarded_pct: the guard); error_all_ticks_pct has them. "
      "Intervals: bootstrap 95 % over motions. ended: runs in which force ended early. tick_ns: "
      "CPU time of the pipeline's mean tick in a motion, median of 24 turns with its interval.");
  auto o = std::make_shared<Options>();
  command->add_option("--motion", o->motions, "a recording: CSV of joint angles; may be repeated")
      ->check(CLI::ExistingFile);
  command->add_option("--trajectories", o->trajectories, "how many (200)")
      ->check(CLI::Range(2, 100000));
  command->add_option("--method", o->method, "this renderer alone");
  add_noise(*command, o->noise, "of the sensors (none)");
  command->add_option("--proxy", o->proxy, "this kind of client alone")
      ->check(CLI::IsMember({"held", "planes", "derived_planes", "contacts"}));
  command->add_option("--rate", o->rate, "of the client, Hz (a choice)")
      ->check(CLI::Range(30.0, 1000.0));
  command->add_option("--delay", o->delay, "ms, 0 to 100 (a choice)")
      ->check(CLI::Range(0.0, 100.0));
  command->callback([o] { print_all(*o); });
}

}  // namespace haptic::report
