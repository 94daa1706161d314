/// haptic-report rate: how stiff a wall may be behind a slow or late simulation, and what its drag
/// and energy are (core/METHOD.md#local-models), on the real Pipeline in virtual time.
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "tests/report/client_kind.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/support/loop/wall_run.hpp"

namespace haptic::report {
namespace {

constexpr double kRounding = 1e-9;  // J: of a few thousand ticks' sums
constexpr double kMilli = 1e3;

constexpr int kTop = 60;  // of the grid

struct Options {
  std::string proxy{}, with{};
  std::optional<double> rate{}, delay{}, stiffness{};
  bool cycles{false};
};

struct Cell {
  ClientKind kind{ClientKind::kHeld};
  bool tank{false};  ///< strictly passive: tank_0 = 0, P_env = 0 (core/METHOD.md#energy-tank)
  Network network{};
};

/// `cycles`: in and out once a second; else a steady press. Z_q in N/m.
test::WallFigures run(const Cell& cell, bool cycles, double stiffness) {
  test::WallRun wall{.cycles = cycles,
                     .stiffness = stiffness,
                     .client = client_of(cell.kind, cell.network, core::VecX::Zero(1)),
                     .passivity = test::wall_tank(0.0)};
  wall.passivity.tank.enabled = cell.tank;
  return test::run(wall);
}

/// core/METHOD.md#local-models: a press is stable where the rms speed ends below 1 mm/s. In and
/// out: where nothing is ever faster than twice the hand's own fastest.
bool stable(bool cycles, const test::WallFigures& figures) {
  constexpr double kStill = 1e-3;  // m/s
  constexpr double kFastestHand = 2.0 * M_PI * test::kWallAmplitude;
  return cycles ? figures.top_speed <= 2.0 * kFastestHand : figures.rms_speed < kStill;
}

double grid_stiffness(int n) {
  return 25.0 * std::pow(1.1, n);
}

/// The largest stiffness of the grid, n = 0..kTop, up to which the loop is stable; 0 where not even
/// the first is. Steps of 1.1^4 first: an island of instability smaller than that may be missed.
double largest_stiffness(const Cell& cell, bool cycles) {
  constexpr int kStride = 4;
  const auto holds = [&](int n) { return stable(cycles, run(cell, cycles, grid_stiffness(n))); };
  int good = -1;
  while (good + kStride <= kTop && holds(good + kStride)) good += kStride;
  for (int end = std::min(good + kStride - 1, kTop); good < end && holds(good + 1);) ++good;
  return good < 0 ? 0.0 : grid_stiffness(good);
}

std::vector<Cell> cells(const Options& options) {
  std::vector<double> rates{30, 60, 120, 200, 1000}, delays{0, 5, 10, 20, 50, 100};
  if (options.rate) rates = {*options.rate};
  if (options.delay) delays = {*options.delay};
  std::vector<Cell> all;
  for (const ClientKind kind : kClientKinds) {
    if (!chosen(options.proxy, name(kind))) continue;
    for (const bool tank : {false, true}) {
      if (!chosen(options.with, tank ? "tank" : "nothing")) continue;
      for (const double rate : rates) {
        for (const double delay : delays) all.push_back({kind, tank, {rate, delay / kMilli}});
      }
    }
  }
  return all;
}

Line what_it_is(const Cell& cell) {
  return line_of(name(cell.kind), cell.network.rate_hz, cell.network.delay_s * kMilli,
                 cell.tank ? "tank" : "nothing");
}
const Line kWhat{"proxy,rate_hz,delay_ms,with"};

void print_stiffness(const Options& options) {
  row(kWhat, "k_max_press_n_per_m", "k_max_cycles_n_per_m", "top_of_grid_n_per_m");
  for (const Cell& cell : cells(options)) {
    row(what_it_is(cell), largest_stiffness(cell, false), largest_stiffness(cell, true),
        grid_stiffness(kTop));
  }
}

void print_cycles(const Options& options) {
  row(kWhat, "stiffness_n_per_m", "drag_n", "predicted_held_drag_n", "given_mj", "net_mj",
      "peak_force_n", "top_speed_m_per_s", "throttled_ticks", "verdict");
  std::vector<double> stiffnesses{500, 1500};
  if (options.stiffness) stiffnesses = {*options.stiffness};
  for (const Cell& cell : cells(options)) {
    const double lag = cell.network.delay_s + 0.5 / cell.network.rate_hz;
    for (const double stiffness : stiffnesses) {
      const test::WallFigures f = run(cell, true, stiffness);
      const bool gives = f.most_net > kRounding;
      row(what_it_is(cell), stiffness, f.drag, stiffness * test::kWallMeanSpeed * lag,
          kMilli * f.most_given, kMilli * f.most_net, f.peak_force,
          std::isfinite(f.top_speed) ? f.top_speed : NAN, f.throttled,
          !stable(true, f) ? "unstable"
          : gives          ? "gives energy"
                           : "ok");
    }
  }
}

constexpr const char* kFooter =
    "One DoF as in core/METHOD.md#local-models: 0.15 kg, 1 N s/m; the hand 300 N/m, 2 N s/m; "
    "jitter 30 % of the client's period, none at 1 kHz.\n"
    "Clients: held_force - the force is held; held - the proxy is; extrapolated - the proxy goes "
    "on "
    "for one period; planes - the wall as a plane in every sample; derived_planes - the plane only "
    "while the simulation sees contact. held_force and extrapolated are not offered by hapticd: "
    "they are measured beside it.\n"
    "k_max_press: largest stiffness (grid 25 x 1.1^n N/m) up to which a steady press ends below 1 "
    "mm/s rms; k_max_cycles: up to which moving in and out of the wall (20 mm, 1 Hz) is never "
    "faster than twice the hand's fastest. top_of_grid: there is no more.\n"
    "drag_n: mean force outside the wall. given_mj: largest over time of the work on the device; "
    "net_mj: less what its damping took. verdict: ok, gives energy (net_mj > 0) or unstable.";

}  // namespace

void add_rate(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "rate", "How stiff a wall may be behind a slow or late client, and its drag and energy");
  command->footer(kFooter);
  auto o = std::make_shared<Options>();
  command->add_option("--proxy", o->proxy, "this kind of client alone")
      ->check(CLI::IsMember({"held_force", "held", "extrapolated", "planes", "derived_planes"}));
  command->add_option("--rate", o->rate, "of the client, Hz (30,60,120,200,1000)")
      ->check(CLI::Range(30.0, 1000.0));
  command->add_option("--delay", o->delay, "ms (0,5,10,20,50,100)")->check(CLI::Range(0.0, 100.0));
  command->add_option("--with", o->with, "this safeguard alone")
      ->check(CLI::IsMember({"nothing", "tank"}));
  auto* cycles = command->add_flag("--cycles", o->cycles,
                                   "instead: drag and energy of moving in and out, at a stiffness");
  command->add_option("--stiffness", o->stiffness, "with --cycles: N/m (500 and 1500)")
      ->check(CLI::Range(1.0, 10000.0))
      ->needs(cycles);
  command->callback([o] { (o->cycles ? print_cycles : print_stiffness)(*o); });
}

}  // namespace haptic::report
