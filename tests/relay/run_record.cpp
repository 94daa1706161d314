#include "tests/relay/run_record.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "tests/relay/daemon.hpp"

namespace haptic::test {
namespace {

constexpr double kHoldEnd = 0.100, kFadeEnd = 0.180;  // proto/README.md#staleness-and-gain, s
constexpr double kSilent = 0.200;
constexpr double kRampUp = 0.200;
constexpr double kTiny = 1e-6;
constexpr double kAgeStep = 1e-6;  // ages are recorded in whole microseconds
constexpr double kGainStep = kTiny + kAgeStep / (kFadeEnd - kHoldEnd);
constexpr double kPeriod = 0.001;  // s, of the daemon's loop

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

double number(const std::string& text) {
  return text.empty() ? 0.0 : std::stod(text);
}

std::string level(double age, double fresh_end) {
  if (age < fresh_end) return "FRESH";
  if (age < kHoldEnd) return "HOLD";
  return age < kFadeEnd ? "FADE" : "LOST";
}

double ladder(double age) {
  return std::clamp((kFadeEnd - age) / (kFadeEnd - kHoldEnd), 0.0, 1.0);
}

/// proto/README.md#staleness-and-gain: a fault takes the gain at once, and the command, damping
/// too, within two ticks.
std::string force_in_fault(const RecordedTick& before, const RecordedTick& now) {
  if (now.state == "FAULT" && (now.gain != 0.0 || now.tau_elastic != 0.0)) {
    return "elastic force in FAULT";
  }
  if (now.faults.empty() || before.faults.empty()) return {};
  if (now.tau_a != 0.0) return "a command of " + std::to_string(now.tau_a) + " N after a fault";
  const bool stopped = now.state == "FAULT" || now.state == "CLOSING" || now.state == "INIT";
  return stopped ? "" : now.state + " while a fault is latched";
}

/// The same sign or nothing, and no more of it.
bool only_taken(double before, double now) {
  return std::abs(now) <= std::abs(before) && now * before >= 0.0;
}

/// tests/relay/README.md#rows: the command never steps by more than the slew limit, except for what
/// is taken away after that limit: all of it by a fault, or if the device is not armed; its elastic
/// part by the force envelope, down to gain times limit and no further. Guard and tank act before
/// the slew limit. Damping, including the passivity controller's, has a slew limit of its own. An
/// actuator's ratings act after it, but this scene has none.
std::string force_step(const RecordedTick& before, const RecordedTick& now) {
  const double dt = now.time - before.time;
  const double most = Daemon::kSlew * dt + kTiny;
  const double step = now.tau_a - before.tau_a;
  if (std::abs(step) <= most) return {};
  const bool armed = now.state == "ARMED" || now.state == "ENGAGING" || now.state == "ENGAGED" ||
                     now.state == "RELEASING";
  const bool fault = !now.faults.empty() || now.state == "FAULT";
  const bool had_spring = std::abs(before.tau_elastic) > kTiny;  // then it has to fade first
  if ((fault || (!armed && !had_spring)) && only_taken(before.tau_a, now.tau_a)) return {};
  const double damping_step = step - (now.tau_elastic - before.tau_elastic);
  const bool on_envelope = std::abs(now.tau_elastic) >= now.gain * Daemon::kForceLimit - kTiny;
  if (on_envelope && only_taken(before.tau_elastic, now.tau_elastic) &&
      std::abs(damping_step) <= most) {
    return {};
  }
  return "force changed by " + std::to_string(step) + " N in " + std::to_string(dt) + " s";
}

/// The first rule that a tick breaks after the one before it; empty: none.
std::string breach_in(const RecordedTick& before, const RecordedTick& now, double fresh_end) {
  const double dt = now.time - before.time;
  if (now.tick <= before.tick || !(dt > 0.0)) return "a tick that is not after the one before";
  for (const double value : {now.age, now.gain, now.slide, now.tau_elastic, now.tau_a}) {
    if (!std::isfinite(value)) return "not a finite number";
  }
  if (std::string wrong = force_in_fault(before, now); !wrong.empty()) return wrong;
  if (std::string wrong = force_step(before, now); !wrong.empty()) return wrong;
  if (now.gain - before.gain > dt / kRampUp + kTiny) return "gain rose by a step";
  if (std::abs(now.tau_elastic) > now.gain * Daemon::kForceLimit + kTiny) {
    return "elastic force above gain times limit";
  }
  // Without this rule a step of the gain would allow any step of the force.
  double least = before.gain - dt / (kFadeEnd - kHoldEnd);
  if (now.mode != "NONE") least = std::min(least, ladder(now.age));
  const bool fault = !now.faults.empty() || now.state == "FAULT";
  if (now.gain < least - kGainStep && !fault) return "gain fell by a step";
  if (now.mode == "NONE") return {};
  if (now.staleness != level(now.age, fresh_end) &&
      now.staleness != level(now.age + kAgeStep, fresh_end)) {
    return now.staleness + " at an age of " + std::to_string(now.age) + " s";
  }
  if (now.gain > ladder(now.age) + kGainStep) return "gain above the ladder";
  if (now.age >= kSilent && now.tau_elastic != 0.0) return "elastic force after 200 ms of silence";
  return {};
}

bool force_on(const RecordedTick& tick) {
  return tick.state == "ENGAGING" || tick.state == "ENGAGED";
}

}  // namespace

std::vector<RecordedTick> read_record(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  std::map<std::string, std::size_t> columns;
  for (const std::string& name : fields_of(line)) columns.emplace(name, columns.size());
  const auto column = [&](const char* name) {
    const auto entry = columns.find(name);
    if (entry == columns.end()) throw std::runtime_error(std::string("no column ") + name);
    return entry->second;
  };
  const std::size_t time = column("time_s"), state = column("state"),
                    staleness = column("staleness"), age = column("proxy_age_us"),
                    mode = column("mode"), gain = column("gain"), slide = column("l_x"),
                    body = column("q_B"), limiters = column("limiters"),
                    elastic = column("tau_elastic_l_x_n"), tau = column("tau_a_l_x_n"),
                    faults = column("faults"), tick = column("seq"),
                    lateness = column("lateness_us"), skipped = column("skipped"),
                    bound = column("error_bound_l_x_n");
  std::vector<RecordedTick> run;
  while (std::getline(stream, line)) {
    std::vector<std::string> f = fields_of(line);
    f.resize(std::max(f.size(), columns.size()));
    run.push_back({number(f[time]), static_cast<std::uint64_t>(number(f[tick])), f[state],
                   f[staleness], f[mode], f[faults], f[limiters], 1e-6 * number(f[age]),
                   number(f[gain]), number(f[slide]), number(f[body]), number(f[elastic]),
                   number(f[tau]), 1e-6 * number(f[lateness]), number(f[skipped])});
    if (!f[bound].empty()) run.back().error_bound = number(f[bound]);
  }
  return run;
}

RunFigures judge(const std::vector<RecordedTick>& run, double fresh_end) {
  RunFigures figures;
  double energy = 0.0, late_work = 0.0;
  for (std::size_t i = 1; i < run.size(); ++i) {
    const RecordedTick& before = run[i - 1];
    const RecordedTick& now = run[i];
    const double dt = now.time - before.time;
    figures.engages += now.state == "ENGAGING" && before.state != "ENGAGING" ? 1 : 0;
    figures.losses += force_on(before) && now.state == "ARMED" ? 1 : 0;
    figures.engaged = figures.engaged || now.state == "ENGAGED";
    figures.skipped += now.skipped;
    figures.latest = std::max(figures.latest, now.lateness);
    if (force_on(now)) figures.oldest = std::max(figures.oldest, now.age);
    if (dt > 0.0) {
      figures.steepest =
          std::max(figures.steepest, (std::abs(now.tau_a) - std::abs(before.tau_a)) / dt);
      // Work of the command held over the tick, less what the actuator's own friction takes.
      const double move = now.slide - before.slide;
      const double work = before.tau_a * move - Daemon::kDeviceDamping * move * move / dt;
      energy += work;
      figures.energy = std::max(figures.energy, energy);
      // A late tick leaves the last command on for longer than the tank was asked about.
      if (dt > 1.5 * kPeriod) late_work += std::max(0.0, work);
    }
    figures.last_state = now.state;
    if (!figures.breach.empty()) continue;
    std::string wrong = breach_in(before, now, fresh_end);
    if (wrong.empty() && before.faults.empty() && !now.faults.empty()) {
      wrong = "fault " + now.faults;
    }
    // Each Engage fills the tank; nothing else may put energy in.
    if (wrong.empty() &&
        figures.energy > Daemon::kTank * std::max(1, figures.engages) + late_work + 1e-3) {
      wrong = std::to_string(figures.energy) + " J given out, more than the tank held";
    }
    if (!wrong.empty()) figures.breach = "at " + std::to_string(now.time) + " s: " + wrong;
  }
  return figures;
}

std::string RunFigures::text() const {
  std::ostringstream text;
  text << std::fixed << "oldest proxy " << static_cast<int>(1e3 * oldest) << " ms; " << engages
       << " engages; " << losses << " losses; steepest rise " << static_cast<int>(steepest)
       << " N/s; energy out " << static_cast<int>(1e3 * energy) << " mJ; "
       << static_cast<int>(skipped) << " deadlines skipped, latest tick "
       << static_cast<int>(1e3 * latest) << " ms; " << last_state << " at the end";
  return text.str();
}

}  // namespace haptic::test
