/// haptic-report rtt: is touch the same at 0 and at 200 ms (core/METHOD.md#contacts)? Objects,
/// peers and round trips, judged by the shadow.
#include <algorithm>
#include <cmath>
#include <optional>

#include "haptic/core/error.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/rtt_study.hpp"

namespace haptic::report {
namespace {

constexpr double kMilli = 1e3;
constexpr double kRoundTrips[]{0.0, 0.010, 0.020, 0.050, 0.100, 0.200};  // s
constexpr double kOneRoundTrip = 0.100;                                  // s, of other rates
constexpr double kLoss = 0.1;
constexpr double kClear = 0.9;  // of the force limit

struct Options {
  std::vector<std::string> motions{};
  std::string object{}, peer{}, noise{};
  std::optional<double> round_trip{}, rate{}, lost{};
  bool trace{false};
};

/// Every round trip at 60 Hz, two other rates, and contacts that lose samples; with an option that
/// one.
std::vector<RttRun> runs(const Options& options) {
  std::vector<RttRun> all;
  for (const RttPeer peer : kRttPeers) {
    if (!chosen(options.peer, name(peer))) continue;
    if (options.round_trip || options.rate || options.lost) {
      all.push_back({peer, options.round_trip.value_or(0.0) / kMilli, options.rate.value_or(60.0),
                     options.lost.value_or(0.0) / 100.0});
      continue;
    }
    for (const double round_trip : kRoundTrips) all.push_back({peer, round_trip});
    for (const double rate : {30.0, 1000.0}) all.push_back({peer, kOneRoundTrip, rate});
    if (peer != RttPeer::kContacts) continue;
    for (const double round_trip : kRoundTrips) all.push_back({peer, round_trip, 60.0, kLoss});
  }
  for (RttRun& how : all) how.noise = sensor_noise(options.noise);
  return all;
}

std::vector<RttScene> scenes(const Options& options) {
  std::vector<RttScene> all = rtt_scenes(options.motions);
  std::erase_if(all, [&](const RttScene& scene) { return !chosen(options.object, scene.name); });
  if (all.empty()) throw core::SceneError("rtt: no object '" + options.object + "'");
  return all;
}

void print_all(const Options& options) {
  const std::vector<RttScene> all = scenes(options);
  row("object", "peer", "round_trip_ms", "rate_hz", "loss_pct", "peak_n", "error_n", "error_pct",
      "largest_n", "energy_mj", "drag_n", "onset_ticks", "held_back_pct", "bounded_pct",
      "bound_holds_pct", "bound_median_n", "error_median_n", "ideal_mj", "contacts",
      "contact_ticks", "samples_per_s", "ended", "band_mn");
  for (const RttScene& scene : all) {
    const RttFigures local = run(scene, {.rate_hz = 1000.0});
    if (local.shadow.peak >= kClear * scene.pipeline.scene.force_limit[0]) {
      std::fprintf(stderr, "rtt: %s is left out: its force comes near the limit\n",
                   scene.name.c_str());
      continue;
    }
    for (const RttRun& how : runs(options)) {
      const RttFigures f = run(scene, how);
      const auto known = [&f](double of_bound) {
        return f.bound.bounded > 0.0 ? of_bound : std::nan("");
      };
      row(scene.name, name(how.peer), kMilli * how.round_trip_s, how.rate_hz, 100.0 * how.lost,
          f.shadow.peak, f.shadow.error, f.shadow.percent(), f.shadow.largest,
          kMilli * (f.most_net - local.most_net), f.shadow.drag, f.shadow.onset,
          100.0 * f.shadow.held_back, 100.0 * f.bound.bounded, known(100.0 * f.bound.kept),
          known(f.bound.bound_median), known(f.bound.error_median), kMilli * f.ideal_net,
          f.shadow.contacts, f.shadow.ticks, f.samples_hz, f.ended ? 1 : 0, kMilli * f.band);
    }
    std::fflush(stdout);
  }
}

/// The force that is felt and its shadow, ms by ms.
void print_trace(const Options& options) {
  row("object", "peer", "round_trip_ms", "t_s", "felt_n", "shadow_n");
  for (const RttScene& scene : scenes(options)) {
    for (const RttRun& how : runs(options)) {
      static_cast<void>(run(scene, how, [&](const RttTick& tick) {
        row(scene.name, name(how.peer), kMilli * how.round_trip_s, tick.t_s, tick.felt,
            tick.shadow);
      }));
    }
  }
}

}  // namespace

void add_rtt(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("rtt", "Force felt by an object that is simulated behind a network");
  command->footer(
      "Virtual time, fixed seeds. error: rms over the ticks in contact of the force felt less the "
      "shadow's, the same contacts evaluated without delay on the probe that was felt; _pct: of "
      "the shadow's peak. energy: most that was given out, beyond the same pipeline with a client "
      "at 1 kHz without delay. drag: largest force farther than 3 mm from the object. onset: most "
      "ticks by which a contact is felt late. held_back: share of the ticks in contact in which "
      "the energy tank acted. ended: force ended early.");
  auto o = std::make_shared<Options>();
  command->add_option("--motion", o->motions, "a recording: CSV of joint angles; may be repeated")
      ->check(CLI::ExistingFile);
  command->add_option("--object", o->object, "this object alone");
  command->add_option("--peer", o->peer, "this peer alone")
      ->check(
          CLI::IsMember({"contacts", "estimated", "derived_planes", "held", "held_force", "tdpa"}));
  command->add_option("--round-trip", o->round_trip, "ms, 0 to 400 (a choice)")
      ->check(CLI::Range(0.0, 400.0));
  command->add_option("--rate", o->rate, "of the client, Hz (a choice)")
      ->check(CLI::Range(30.0, 1000.0));
  add_noise(*command, o->noise, "of the sensors (none)");
  command->add_option("--lost", o->lost, "samples that are lost, % (0)")
      ->check(CLI::Range(0.0, 50.0));
  command->add_flag("--trace", o->trace, "the first actuator's force, tick by tick");
  command->callback([o] { (o->trace ? print_trace : print_all)(*o); });
}

}  // namespace haptic::report
