/// haptic-report finger: what the finger feels (core/METHOD.md#forces-at-the-finger), on the real
/// Pipeline with the simulated finger in virtual time.
#include <map>
#include <optional>
#include <tuple>

#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/finger_press.hpp"

namespace haptic::report {
namespace {

/// Tolerance of "never deeper than without force"
/// (tests/report/STUDY.md#chosen-presses-finger_sign_change).
constexpr double kDeeper_deg = 0.5;
constexpr double kWork_mj = 1e-3;  // the integration's own noise is far below

struct Options {
  std::optional<Pair> stop{}, target{};
  std::optional<double> stiffness{};
  std::string method{};
  bool guard{false}, tank{false}, grid{false}, joints{false}, trace{false};
  bool board{false};
};

/// tests/report/STUDY.md#chosen-presses-finger_sign_change: the table's rows; with --grid its 24
/// runs; with any of the three options that one.
std::vector<Press> runs(const Options& options) {
  std::vector<Press> presses;
  const auto add = [&](const Pair& stop, const Pair& target, double stiffness) {
    Press press;
    press.stop_deg = stop;
    press.target_deg = target;
    press.stiffness = stiffness;
    press.direction_guard = options.guard;
    press.energy_tank = options.tank;
    press.board = options.board;
    presses.push_back(press);
  };
  const Press standard{};
  if (options.stop || options.target || options.stiffness) {
    add(options.stop.value_or(standard.stop_deg), options.target.value_or(standard.target_deg),
        options.stiffness.value_or(standard.stiffness));
  } else if (options.grid) {
    for (const Pair& target : {Pair{50, 50}, Pair{60, 80}, Pair{20, 60}}) {
      for (const Pair& stop :
           {Pair{18, kNoStop}, Pair{5, kNoStop}, Pair{kNoStop, 25}, Pair{18, 25}}) {
        for (const double stiffness : {1500.0, 6000.0}) add(stop, target, stiffness);
      }
    }
  } else {
    add({18, kNoStop}, {50, 50}, 1500);
    add({18, kNoStop}, {50, 50}, 6000);
    add({kNoStop, 25}, {50, 50}, 1500);
    add({18, 25}, {50, 50}, 1500);
  }
  return presses;
}

std::vector<core::RendererKind> methods(const Options& options) {
  std::vector<core::RendererKind> all(kMethods.begin(), kMethods.end());
  std::erase_if(all, [&](auto kind) { return !chosen(options.method, core::name(kind)); });
  return all;
}

std::string verdict(const Felt& felt, double no_force_deg) {
  const bool deeper = felt.max_penetration_deg > no_force_deg + kDeeper_deg;
  const bool active = 1e3 * felt.net_work > kWork_mj;
  if (deeper) return active ? "deeper and gives energy" : "deeper";
  return active ? "gives energy" : "ok";
}

/// Penetration of the same press without force; no method makes a difference to it.
double without_force(Press press,
                     std::map<std::tuple<double, double, double, double>, double>& seen) {
  const auto [entry, first] = seen.try_emplace({press.stop_deg.first, press.stop_deg.second,
                                                press.target_deg.first, press.target_deg.second});
  press.force = false;
  if (first) entry->second = report::press(press).max_penetration_deg;
  return entry->second;
}

void print_results(const Options& options) {
  Line header =
      line_of("method", "stop_mcp_deg", "stop_pip_deg", "target_mcp_deg", "target_pip_deg",
              "stiffness_n_per_m", "end_mcp_deg", "end_pip_deg", "max_penetration_deg",
              "no_force_penetration_deg", "peak_force_n", "work_mj", "verdict");
  if (options.joints) {
    header = line_of(header, "end_force_n", "end_mcp_torque_nmm", "end_pip_torque_nmm",
                     "net_work_mj", "withheld_ticks", "throttled_ticks");
  }
  if (options.board) {
    header =
        line_of(header, "peak_cell_n", "end_cell_n", "peak_mcp_torque_nmm", "peak_pip_torque_nmm");
  }
  row(header);
  std::map<std::tuple<double, double, double, double>, double> seen;
  for (Press press : runs(options)) {
    const double no_force = without_force(press, seen);
    for (const core::RendererKind kind : methods(options)) {
      press.method = kind;
      const Felt felt = report::press(press);
      Line line = line_of(core::name(kind), press.stop_deg.first, press.stop_deg.second,
                          press.target_deg.first, press.target_deg.second, press.stiffness,
                          felt.end.x_deg.first, felt.end.x_deg.second, felt.max_penetration_deg,
                          no_force, felt.peak_force, 1e3 * felt.work, verdict(felt, no_force));
      if (options.joints) {
        line =
            line_of(line, felt.end.tau_a, 1e3 * felt.end.tau_x.first, 1e3 * felt.end.tau_x.second,
                    1e3 * felt.net_work, felt.withheld, felt.throttled);
      }
      if (options.board) {
        line = line_of(line, felt.peak_cell, felt.end.cell, 1e3 * felt.peak_tau_x.first,
                       1e3 * felt.peak_tau_x.second);
      }
      row(line);
    }
  }
}

void print_trace(const Options& options) {
  row("method", "stop_mcp_deg", "stop_pip_deg", "stiffness_n_per_m", "t_s", "mcp_deg", "pip_deg",
      "force_n", "mcp_torque_nmm", "pip_torque_nmm");
  for (Press press : runs(options)) {
    for (const core::RendererKind kind : methods(options)) {
      press.method = kind;
      static_cast<void>(report::press(press, [&](const PressTick& tick) {
        row(core::name(kind), press.stop_deg.first, press.stop_deg.second, press.stiffness,
            tick.t_s, tick.x_deg.first, tick.x_deg.second, tick.tau_a, 1e3 * tick.tau_x.first,
            1e3 * tick.tau_x.second);
      }));
    }
  }
}

}  // namespace

void add_finger(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("finger", "Presses against stops at the joints, as the finger feels them");
  command->footer(
      "Without options: the rows of tests/report/STUDY.md#chosen-presses-finger_sign_change. 999 = "
      "no stop. Forces in N at the actuator, positive towards larger l_x; peak_force_n keeps its "
      "sign. work_mj: put into the finger; negative: "
      "taken from it.\nverdict: ok; deeper (more than 0.5 deg beyond where the finger ends without "
      "any force); gives energy (more than the device's own damping took back).");
  auto options = std::make_shared<Options>();
  add_pair(*command, "--stop", options->stop, "M_DEG,P_DEG (18,999)");
  add_pair(*command, "--target", options->target, "M_DEG,P_DEG (50,50)");
  command->add_option("--stiffness", options->stiffness, "Z_q in N/m (1500)")
      ->check(CLI::PositiveNumber);
  command->add_option("--method", options->method, "this method alone")
      ->check(CLI::IsMember({"standard", "null_space", "subspace_linear", "subspace_exact"}));
  command->add_flag("--guard", options->guard, "with the direction guard");
  command->add_flag("--tank", options->tank, "with the energy tank, strictly passive");
  command->add_flag(
      "--board", options->board,
      "through the serial protocol and an emulated board with its L16 and force loop; "
      "work, cell and torques are then those of the load cell and the finger itself");
  command->add_flag("--grid", options->grid,
                    "the 24 runs of tests/report/STUDY.md#chosen-presses-finger_sign_change");
  command->add_flag(
      "--joints", options->joints,
      "adds the end force at actuator and joints, the net work, ticks guarded and throttled");
  command->add_flag("--trace", options->trace, "every tick instead: what the plot is made of");
  command->callback([options] { (options->trace ? print_trace : print_results)(*options); });
}

}  // namespace haptic::report
