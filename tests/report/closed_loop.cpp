/// haptic-report closed-loop: energy per cycle with a client in the loop (core/METHOD.md#results),
/// on the real Pipeline in virtual time.
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/report/chosen_linkage.hpp"
#include "tests/report/client_kind.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/finger_loop.hpp"
#include "tests/report/finger_press.hpp"
#include "tests/support/loop/local_laws.hpp"

namespace haptic::report {
namespace {

constexpr double kRounding = 1e-9;  // J: of a few thousand ticks' sums
constexpr double kMilli = 1e3;
constexpr std::array kMotions{Motion::kCycle, Motion::kHand, Motion::kPress};
constexpr std::array kSafeguards{Safeguard::kNothing, Safeguard::kGuard, Safeguard::kGuardTank};
constexpr std::string_view kQMetric = "q_metric";
constexpr Pair kFreeSpace{80.0, 100.0};  // deg: the hand's cycle stays far from it

struct Options {
  std::string motion{}, method{}, proxy{}, with{}, direction{};
  std::optional<Pair> stop{};
  std::optional<double> rate{}, delay{};
  double stiffness{1500.0}, tank_mj{0.0}, sensed_weight{30.0};
  bool trace{false};
};

/// How a client sends: which proxy, over which network.
struct Sending {
  ClientKind kind{ClientKind::kHeld};
  Network network{};
};

std::vector<Sending> sendings(const Options& options) {
  std::vector<Sending> all{
      {ClientKind::kHeld, {1000, 0.0}},          {ClientKind::kHeld, {60, 0.0}},
      {ClientKind::kHeld, {60, 0.020}},          {ClientKind::kHeld, {200, 0.020}},
      {ClientKind::kHeld, {30, 0.050}},          {ClientKind::kPlanes, {60, 0.020}},
      {ClientKind::kDerivedPlanes, {60, 0.020}},
  };
  if (options.rate || options.delay) {
    all.clear();
    for (const ClientKind kind : kClientKinds) {
      if (options.proxy.empty() && kind != ClientKind::kHeld && kind != ClientKind::kPlanes) {
        continue;
      }
      all.push_back({kind, {options.rate.value_or(60.0), options.delay.value_or(0.0) / kMilli}});
    }
  } else if (chosen(options.proxy, "held_force") && !options.proxy.empty()) {
    all = {{ClientKind::kHeldForce, {60, 0.020}}};
  } else if (chosen(options.proxy, "extrapolated") && !options.proxy.empty()) {
    all = {{ClientKind::kExtrapolated, {60, 0.020}}};
  }
  std::erase_if(all, [&](const Sending& s) { return !chosen(options.proxy, name(s.kind)); });
  return all;
}

std::vector<Pair> stops(const Options& options) {
  if (options.stop) return {*options.stop};
  return {{18, kNoStop}, {kNoStop, 25}, {18, 25}, kFreeSpace};
}

core::VecX radians(const Pair& stop) {
  const auto one = [](double deg) {
    return deg == kNoStop ? std::numeric_limits<double>::infinity() : deg * kDegree;
  };
  return (core::VecX(2) << one(stop.first), one(stop.second)).finished();
}

/// One row's run and the names of what only a name tells.
struct Row {
  FingerLoop loop{};
  Pair stop{};
  std::string_view method{}, proxy{};
};

/// The rejected form of core/METHOD.md#local-models: the exact method renders its proxy and returns
/// it as it is.
Row q_metric_row(const Options& options, const Pair& stop, const Network& network) {
  Row row;
  row.stop = stop;
  row.method = kQMetric;
  row.proxy = kQMetric;
  row.loop.method = core::RendererKind::kSubspaceExact;
  row.loop.client = client_of(ClientKind::kHeld, network, radians(stop));
  row.loop.client.between = test::q_metric(
      {core::make_finger_exoskeleton(chosen_linkage()), radians(stop), options.sensed_weight});
  return row;
}

/// Every method under every client, without motion, safeguard and direction.
std::vector<Row> cases(const Options& options) {
  std::vector<Row> rows;
  for (const Pair& stop : stops(options)) {
    for (const Sending& sending : sendings(options)) {
      for (const core::RendererKind method : kMethods) {
        if (!chosen(options.method, core::name(method))) continue;
        Row row;
        row.stop = stop;
        row.method = core::name(method);
        row.proxy = name(sending.kind);
        row.loop.method = method;
        row.loop.client = client_of(sending.kind, sending.network, radians(stop));
        rows.push_back(std::move(row));
      }
    }
    if (!chosen(options.method, kQMetric) || !chosen(options.proxy, kQMetric)) continue;
    for (const double rate : {1000.0, 60.0}) {
      if (options.rate && *options.rate != rate) continue;
      rows.push_back(q_metric_row(options, stop, {rate, options.delay.value_or(0.0) / kMilli}));
    }
  }
  return rows;
}

/// In free space there is nothing but drag to see: the hand's cycle, one way, unguarded.
bool of_interest(const Row& row) {
  const bool free = row.stop.first == kFreeSpace.first && row.stop.second == kFreeSpace.second;
  if (free && (row.loop.motion != Motion::kHand || row.loop.reversed)) return false;
  return !(row.loop.motion == Motion::kPress && row.loop.reversed);
}

std::vector<Row> rows(const Options& options) {
  std::vector<Row> all;
  for (const Motion motion : kMotions) {
    if (!chosen(options.motion, name(motion))) continue;
    for (Row row : cases(options)) {
      row.loop.motion = motion;
      row.loop.stiffness = options.stiffness;
      row.loop.tank_initial = options.tank_mj / kMilli;
      for (const Safeguard with : kSafeguards) {
        if (!chosen(options.with, name(with))) continue;
        row.loop.with = with;
        for (const bool reversed : {false, true}) {
          row.loop.reversed = reversed;
          if (!chosen(options.direction, reversed ? "reversed" : "forward")) continue;
          if (of_interest(row)) all.push_back(row);
        }
      }
    }
  }
  return all;
}

Line what_it_is(const Row& row) {
  return line_of(name(row.loop.motion), row.stop.first, row.stop.second, row.method, row.proxy,
                 row.loop.client.rate_hz, row.loop.client.delay_s * kMilli, name(row.loop.with),
                 row.loop.reversed ? "reversed" : "forward");
}
const Line kWhat{"motion,stop_mcp_deg,stop_pip_deg,method,proxy,rate_hz,delay_ms,with,direction"};

void print_figures(const Options& options) {
  row(kWhat, "given_mj", "net_mj", "most_net_mj", "peak_storage_mj", "given_pct", "mean_force_n",
      "peak_force_n", "max_penetration_deg", "withheld_ticks", "throttled_ticks", "verdict");
  for (const Row& one : rows(options)) {
    const LoopFigures f = run(one.loop);
    const bool ok = f.most_net <= one.loop.tank_initial + kRounding;
    // The energy of a throttled spring says nothing of the method.
    const bool throttled = f.throttled > 0 || f.peak_storage == 0.0;
    row(what_it_is(one), kMilli * f.given, kMilli * f.net, kMilli * f.most_net,
        kMilli * f.peak_storage, throttled ? NAN : 100.0 * f.given / f.peak_storage, f.mean_force,
        f.peak_force, f.max_penetration_deg, f.withheld, f.throttled, ok ? "ok" : "gives energy");
  }
}

void print_trace(const Options& options) {
  row(kWhat, "t_s", "mcp_deg", "pip_deg", "force_n", "given_mj", "net_mj");
  for (const Row& one : rows(options)) {
    const Line what = what_it_is(one);
    static_cast<void>(run(one.loop, [&](const LoopTick& tick) {
      row(what, tick.t_s, tick.x_deg.first, tick.x_deg.second, tick.tau_a, kMilli * tick.given,
          kMilli * tick.net);
    }));
  }
}

constexpr const char* kFooter =
    "Motions: cycle - the device is led round l_x +-2 mm, q_B +-0.05 rad about (30,30) deg; hand - "
    "the hand aims round (35 + 15 cos, 35 + 15 sin) deg, the finger follows; press - it aims at "
    "(50,50) deg and stays. The last of four cycles of 1 s is reported; reversed: the other way "
    "round. The stop 80,100 is out of reach: a force there is drag.\n"
    "method q_metric: the form that core/METHOD.md#local-models rejects, conservative in the "
    "metric "
    "of Q, M_n = c (0.02 m/rad)^2 Z_q.\n"
    "given_mj: to the user in the cycle or press; net_mj: less what the device's own damping, 2 N "
    "s/m, took; most_net_mj: the largest net sum over time since force came on. given_pct: of the "
    "spring's largest energy in the cycle, nan where the tank held it back. mean_force_n: of the "
    "magnitude.\n"
    "verdict: ok, or gives energy: most_net_mj is more than the tank held at first.";

}  // namespace

void add_closed_loop(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("closed-loop", "Energy per cycle with a client in the loop");
  command->footer(kFooter);
  auto o = std::make_shared<Options>();
  command->add_option("--motion", o->motion, "this motion alone")
      ->check(CLI::IsMember({"cycle", "hand", "press"}));
  add_pair(*command, "--stop", o->stop, "M_DEG,P_DEG, 999 = none (MCP, PIP, both; free space)");
  command->add_option("--method", o->method, "this method alone")
      ->check(CLI::IsMember(
          {"standard", "null_space", "subspace_linear", "subspace_exact", "q_metric"}));
  command->add_option("--proxy", o->proxy, "this kind of client alone")
      ->check(CLI::IsMember(
          {"held_force", "held", "extrapolated", "planes", "derived_planes", "q_metric"}));
  command->add_option("--rate", o->rate, "of the client, Hz (a choice)")
      ->check(CLI::Range(30.0, 1000.0));
  command->add_option("--delay", o->delay, "ms, 0 to 100 (a choice)")
      ->check(CLI::Range(0.0, 100.0));
  command->add_option("--with", o->with, "this safeguard alone")
      ->check(CLI::IsMember({"nothing", "guard", "guard_tank"}));
  command->add_option("--direction", o->direction, "this direction alone")
      ->check(CLI::IsMember({"forward", "reversed"}));
  command->add_option("--stiffness", o->stiffness, "Z_q in N/m")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_option("--tank-mj", o->tank_mj, "what the tank holds at first")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 50.0));
  command->add_option("--sensed-weight", o->sensed_weight, "c of M_n")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_flag("--trace", o->trace, "every tick instead: what the plot is made of");
  command->callback([o] { (o->trace ? print_trace : print_figures)(*o); });
}

}  // namespace haptic::report
