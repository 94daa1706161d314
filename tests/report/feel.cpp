/// haptic-report feel: what a hand notices, press by press and motion by motion
/// (tests/report/STUDY.md#feel).
#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"
#include "tests/report/bootstrap.hpp"
#include "tests/report/chosen_linkage.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/feel_study.hpp"
#include "tests/support/percentile.hpp"

namespace haptic::report {
namespace {

constexpr double kMilli = 1e3, kPercent = 100.0;
constexpr double kRounding = 1e-9;  // J
constexpr std::uint64_t kSeed = 19;

struct Options {
  std::string noise{}, method{"per_contact"}, client{}, trace{};
  int presses{600}, motions{250}, only{0};
  double stiffness{1500.0};
  std::uint64_t seed{kSeed};
  bool drive{false}, each{false};
};

struct Felt {
  FeelTask task{};
  FeelFigures figures{};
  bool spared{true};  ///< not throttled, or not passive without a tank either
  double kept{1.0};   ///< of the mean force without a tank, if not spared
  /// The worst of it over its limit: 1 is what may be felt.
  [[nodiscard]] double worst() const {
    const auto tank = figures.step[static_cast<std::size_t>(FeelCause::kTank)];
    return std::max({figures.felt.weighted, std::max(tank, figures.guard_step()) / kFeltStep});
  }
};

std::vector<FeelTask> tasks(const Options& options, const core::Kinematics& finger) {
  std::vector<FeelTask> all;
  for (int i = 0; i < options.presses; ++i) {
    all.push_back(feel_task(random_press(options.seed, i, finger)));
  }
  if (options.motions > 0) {
    const FeltMotions motions = felt_motions(finger, {}, options.motions, options.seed);
    int index = 0;
    for (const FeltTrajectory& motion : motions.trajectories) {
      all.push_back(feel_task(motion, index++));
    }
  }
  std::erase_if(all, [&](const FeelTask& task) { return !chosen(options.client, task.client); });
  return all;
}

FeltDevice device_of(const Options& options, std::shared_ptr<const core::Kinematics> finger) {
  FeltDevice device = felt_device(std::move(finger));
  for (const core::RendererKind kind : core::kRenderers) {
    if (core::name(kind) == options.method) device.pipeline.scene.renderer = kind;
  }
  device.pipeline.scene.stiffness.setConstant(options.stiffness);
  return device;
}

Felt felt(const FeelTask& task, const FeltDevice& device, FeelRun how) {
  Felt out{task, run(task, device, how)};
  if (out.figures.throttled == 0 || !task.press) return out;
  how.tank = false;
  const FeelFigures untanked = run(task, device, how);
  out.spared = untanked.given > out.figures.tank_0 + kRounding;
  if (!out.spared) out.kept = out.figures.force / untanked.force;
  return out;
}

/// A group's percentile of a figure, with its interval.
template <typename Figure>
Interval share_of(const std::vector<Felt>& all, double p, const Figure& figure) {
  return interval_of(all.size(), [&](const std::vector<std::size_t>& index) {
    std::vector<double> values;
    for (const std::size_t i : index) values.push_back(figure(all[i].figures));
    return test::percentile(values, p);
  });
}
/// One sum of squares in % of another, of the rms.
Interval rms_of(const std::vector<Felt>& all, double FeelFigures::*part,
                double FeelFigures::*whole) {
  return interval_of(all.size(), [&](const std::vector<std::size_t>& index) {
    double error = 0.0, ideal = 0.0;
    for (const std::size_t i : index) {
      error += all[i].figures.*part;
      ideal += all[i].figures.*whole;
    }
    return ideal > 0.0 ? kPercent * std::sqrt(error / ideal) : NAN;
  });
}
double toggles_of(const FeelFigures& figures) {
  return figures.contact > 0 ? kMilli * figures.toggles / figures.contact : 0.0;
}
double band_tip(const FeelFigures& figures) {
  return kMilli * figures.felt.tip;
}

void print(const std::vector<Felt>& all, std::string_view noise, const Options& options,
           std::string_view group) {
  if (all.empty()) return;
  const auto most = [&](const auto& figure) {
    double value = 0.0;
    for (const Felt& one : all) value = std::max(value, figure(one));
    return value;
  };
  const auto sum = [&](const auto& figure) {
    double value = 0.0;
    for (const Felt& one : all) value += figure(one);
    return value;
  };
  const double n = static_cast<double>(all.size());
  const auto step = [&](FeelCause cause) {
    return most([&](const Felt& f) { return f.figures.step[static_cast<std::size_t>(cause)]; });
  };
  const double throttled = sum([](const Felt& f) { return f.figures.throttled; });
  const Line vibration = line_of(
      share_of(all, 0.5, band_tip),
      share_of(all, 0.95, [](const FeelFigures& f) { return kMilli * f.felt.actuator; }),
      share_of(all, 0.95, band_tip),
      share_of(all, 0.95, [](const FeelFigures& f) { return kMilli * f.untanked.tip; }).value,
      share_of(all, 0.95, [](const FeelFigures& f) { return f.felt.weighted; }),
      kPercent / n * sum([](const Felt& f) { return f.figures.felt.weighted < 1.0; }));
  const Line steps = line_of(
      step(FeelCause::kTank), step(FeelCause::kGuard), step(FeelCause::kBand),
      step(FeelCause::kOnset), step(FeelCause::kSample), step(FeelCause::kMotion),
      sum([](const Felt& f) { return f.figures.guard_step() > kFeltStep; }),
      share_of(all, 0.95, toggles_of), most([](const Felt& f) { return toggles_of(f.figures); }));
  row(noise, options.drive ? "rough" : "ideal", options.method, options.stiffness, group,
      all.size(), vibration, steps, throttled,
      sum([](const Felt& f) { return f.figures.throttled > 0; }),
      throttled > 0.0 ? kPercent * sum([](const Felt& f) { return f.figures.rough; }) / throttled
                      : 0.0,
      sum([](const Felt& f) { return !f.spared; }),
      kPercent * (1.0 - most([](const Felt& f) { return 1.0 - f.kept; })),
      sum([](const Felt& f) { return f.figures.net > f.figures.tank_0 + 1e-6; }),
      kMilli * most([](const Felt& f) { return f.figures.net; }),
      rms_of(all, &FeelFigures::error2, &FeelFigures::ideal2),
      rms_of(all, &FeelFigures::added2, &FeelFigures::clean2),
      sum([](const Felt& f) { return f.figures.ended; }));
}

void print_each(const Felt& f, std::string_view noise) {
  const auto& s = f.figures.step;
  row(noise, f.task.press ? "press" : "motion", f.task.index, f.task.walls, f.task.client,
      f.worst(), kMilli * f.figures.felt.actuator, band_tip(f.figures), f.figures.felt.weighted,
      s[0], s[1], s[2], s[3], s[4], s[5], toggles_of(f.figures), f.figures.throttled,
      f.figures.rough, kPercent * f.kept, kMilli * f.figures.net,
      kPercent * std::sqrt(f.figures.error2 / f.figures.ideal2),
      kPercent * std::sqrt(f.figures.added2 / f.figures.clean2));
}

void print_header(bool each) {
  if (each) {
    row("noise", "kind", "index", "walls", "client", "worst", "actuator_mn", "tip_mn", "weighted",
        "tank_n_per_ms", "guard_n_per_ms", "band_n_per_ms", "onset_n_per_ms", "sample_n_per_ms",
        "motion_n_per_ms", "toggles_per_s", "throttled_ticks", "rough_ticks", "kept_pct", "net_mj",
        "error_pct", "added_pct");
    return;
  }
  row("noise", "drive", "method", "stiffness_n_per_m", "group", "runs", "tip_median_mn",
      "tip_median_lower_mn", "tip_median_upper_mn", "actuator_95_mn", "actuator_95_lower_mn",
      "actuator_95_upper_mn", "tip_95_mn", "tip_95_lower_mn", "tip_95_upper_mn",
      "tip_95_untanked_mn", "weighted_95", "weighted_95_lower", "weighted_95_upper",
      "below_threshold_pct", "tank_n_per_ms", "guard_n_per_ms", "band_n_per_ms", "onset_n_per_ms",
      "sample_n_per_ms", "motion_n_per_ms", "guard_or_band_runs", "toggles_95_per_s",
      "toggles_95_lower_per_s", "toggles_95_upper_per_s", "toggles_most_per_s", "throttled_ticks",
      "throttled_runs", "rough_pct", "throttled_though_passive", "least_kept_pct", "over_tank",
      "most_net_mj", "error_pct", "error_lower_pct", "error_upper_pct", "added_pct",
      "added_lower_pct", "added_upper_pct", "ended");
}

std::vector<SensorNoise> noises(const Options& options) {
  std::vector<SensorNoise> all(kSensorNoises.begin(), kSensorNoises.end());
  std::erase_if(all, [&](SensorNoise noise) { return !chosen(options.noise, name(noise)); });
  return all;
}

void print_all(const Options& options) {
  const std::shared_ptr<const core::Kinematics> finger =
      core::make_finger_exoskeleton(chosen_linkage());
  const FeltDevice device = device_of(options, finger);
  const std::vector<FeelTask> all = tasks(options, *finger);
  print_header(options.each);
  for (const SensorNoise noise : noises(options)) {
    std::vector<Felt> runs;
    for (const FeelTask& task : all) {
      runs.push_back(felt(task, device, {noise, options.drive ? kRoughDrive : FeelDrive{}}));
      if (options.each) print_each(runs.back(), name(noise));
    }
    if (options.each) continue;
    const auto group = [&](std::string_view called, const auto& member) {
      std::vector<Felt> some;
      for (const Felt& one : runs) {
        if (member(one.task)) some.push_back(one);
      }
      print(some, name(noise), options, called);
    };
    group("press", [](const FeelTask& t) { return t.press; });
    for (const char* walls : {"mcp", "pip", "both", "slanted"}) {
      group("press_" + std::string(walls),
            [&](const FeelTask& t) { return t.press && t.walls == walls; });
    }
    group("motion", [](const FeelTask& t) { return !t.press; });
    for (const PressClient& client : kPressClients) {
      group("motion_" + std::string(client.name),
            [&](const FeelTask& t) { return !t.press && t.client == client.name; });
    }
    std::fflush(stdout);
  }
}

void print_trace(const Options& options) {
  const std::shared_ptr<const core::Kinematics> finger =
      core::make_finger_exoskeleton(chosen_linkage());
  const FeltDevice device = device_of(options, finger);
  row("noise", "kind", "index", "t_s", "mcp_deg", "pip_deg", "force_n", "untanked_n", "plain_n",
      "ideal_n", "limiters");
  for (const FeelTask& task : tasks(options, *finger)) {
    if (task.index != options.only || task.press != (options.trace == "press")) continue;
    for (const SensorNoise noise : noises(options)) {
      const FeelRun how{noise, options.drive ? kRoughDrive : FeelDrive{}};
      static_cast<void>(run(task, device, how, [&](const FeelTick& tick) {
        row(name(noise), options.trace, task.index, tick.t_s, tick.x[0] / kDegree,
            tick.x[1] / kDegree, tick.tau, tick.untanked, tick.plain, tick.ideal,
            tick.limiters.bits());
      }));
    }
  }
}

}  // namespace

void add_feel(CLI::App& app) {
  CLI::App* command = app.add_subcommand("feel", "What a hand notices: vibration, steps, clicks");
  command->footer(
      "Random presses (as press) and motions into objects and back (as felt) on the pipeline of "
      "the scene finger_soft_grasp, by turns with the four clients of press, virtual time. "
      "actuator, tip: rms from 50 to 500 Hz, of a press in its last 0.5 s, of a motion while in "
      "contact. weighted: predicted way of the fingertip by the published threshold, below 1 it is "
      "not felt. N per ms: largest step, of the tank beyond the same motion without it, of guard "
      "and rule per contact beyond Eq. (8), and of that. rough: throttled ticks whose step of the "
      "tank is above 0.15. least_kept: force of a press that is passive without a tank. error: of "
      "the torque at both joints against no noise, no tank and planes in every tick, at the "
      "stiffness in effect. added: against the same client without noise, its filters and tank.");
  auto o = std::make_shared<Options>();
  add_noise(*command, o->noise, "of the sensors (all kinds)");
  command->add_option("--method", o->method, "renderer (per_contact)");
  command->add_option("--client", o->client, "this one alone")
      ->check(CLI::IsMember({"held", "held_late", "planes", "planes_late"}));
  command->add_option("--presses", o->presses, "how many (600)")->check(CLI::NonNegativeNumber);
  command->add_option("--motions", o->motions, "how many (250)")->check(CLI::NonNegativeNumber);
  command->add_option("--stiffness", o->stiffness, "Z_q in N/m (1500)")->check(CLI::PositiveNumber);
  command->add_option("--seed", o->seed, "of the presses and motions");
  command->add_flag("--drive", o->drive, "a drive with friction of 1 N and cogging of 0.5 N");
  command->add_flag("--each", o->each, "a row per press and motion");
  command->add_option("--trace", o->trace, "every tick of one: press or motion")
      ->check(CLI::IsMember({"press", "motion"}));
  command->add_option("--index", o->only, "its number");
  command->callback([o] { (o->trace.empty() ? print_all : print_trace)(*o); });
}

}  // namespace haptic::report
