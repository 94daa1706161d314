/// The judge of records finds breaches: a good run passes, each changed one has the named breach.
/// Limits are those of proto/README.md#staleness-and-gain and of the scene (daemon.hpp).

#include "tests/relay/run_record.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

namespace haptic::test {
namespace {

constexpr double kFreshUntil = 0.025;  // s
constexpr std::size_t kRecorded = 100, kFaultTick = 50;

using Record = std::vector<RecordedTick>;
using Change = std::function<void(Record&)>;

/// 1 kHz, a proxy of 5 ms, a finger that stands still and is pushed with 10 N.
Record pushing() {
  Record run;
  for (std::size_t i = 0; i < kRecorded; ++i) {
    RecordedTick tick;
    tick.time = 1e-3 * static_cast<double>(i);
    tick.tick = i + 1;
    tick.state = "ENGAGED";
    tick.staleness = "FRESH";
    tick.mode = "HELD";
    tick.age = 0.005;
    tick.gain = 1.0;
    tick.tau_elastic = tick.tau_a = 10.0;
    run.push_back(tick);
  }
  return run;
}

/// From tick `first` on: the elastic force and the damping, N.
Change force_from(std::size_t first, double elastic, double damping = 0.0) {
  return [=](Record& run) {
    for (std::size_t i = first; i < kRecorded; ++i) {
      run[i].tau_elastic = elastic;
      run[i].tau_a = elastic + damping;
    }
  };
}

/// From tick `first` on: an old proxy, with the gain of the ladder at that age.
Change fade_from(std::size_t first, double age, const std::string& level) {
  return [=](Record& run) {
    for (std::size_t i = first; i < kRecorded; ++i) {
      run[i].age = age;
      run[i].staleness = level;
      run[i].gain = level == "FADE" ? (0.180 - age) / 0.080 : 0.0;
    }
  };
}

Change gain_from_30(double gain) {
  return [=](Record& run) {
    for (std::size_t i = 30; i < kRecorded; ++i) run[i].gain = gain;
  };
}

/// From tick 50 on: a fault, which takes the force.
void fault(Record& run) {
  for (std::size_t i = kFaultTick; i < kRecorded; ++i) {
    run[i].state = "FAULT";
    run[i].faults = "DEVICE_SILENT";
    run[i].gain = run[i].tau_elastic = run[i].tau_a = 0.0;
  }
}

/// No longer armed from tick 30 on, and without the damping of before.
void disarmed(Record& run) {
  fade_from(0, 0.190, "LOST")(run);
  force_from(0, 0.0, -5.0)(run);
  for (std::size_t i = 30; i < kRecorded; ++i) run[i].state = "IDLE";
  force_from(30, 0.0)(run);
}

/// `tick` 0: no breach is expected; else one of that tick, which begins with `what`.
void expect_breach(const std::string& name, std::initializer_list<Change> changes,
                   std::size_t tick = 0, const std::string& what = {}) {
  Record run = pushing();
  for (const Change& change : changes) change(run);
  const std::string wanted =
      tick == 0 ? "" : "at " + std::to_string(1e-3 * static_cast<double>(tick)) + " s: " + what;
  const std::string found = judge(run, kFreshUntil).breach;
  EXPECT_EQ(found.substr(0, wanted.size()), wanted) << name;
  EXPECT_EQ(found.empty(), wanted.empty()) << name << ": " << found;
}

TEST(RunRecord, JudgesEachTick) {
  const auto at_30 = [](double RecordedTick::*field, double value) {
    return [=](Record& run) { run[30].*field = value; };
  };
  expect_breach("nothing", {});
  expect_breach("jump", {at_30(&RecordedTick::tau_a, 11.1)}, 30, "force");
  expect_breach("allowed rise", {at_30(&RecordedTick::tau_a, 10.9)});
  expect_breach("above the envelope", {at_30(&RecordedTick::gain, 0.3)}, 30, "elastic force above");
  expect_breach("no gain", {at_30(&RecordedTick::gain, 0.0)}, 30, "elastic");
  expect_breach("old, said fresh", {at_30(&RecordedTick::age, 0.030)}, 30, "FRESH at an age");
  expect_breach("NaN", {at_30(&RecordedTick::tau_a, std::numeric_limits<double>::quiet_NaN())}, 30,
                "not a finite");
  expect_breach("a tick twice", {[](Record& run) { run[30].tick = 30; }}, 30, "a tick");
  expect_breach("a clock that stands", {[](Record& run) { run[30].time = run[29].time; }}, 29,
                "a tick");
}

TEST(RunRecord, JudgesForceInAFault) {
  const auto set = [](std::size_t tick, double RecordedTick::*field, double value) {
    return [=](Record& run) { run[tick].*field = value; };
  };
  // The fault itself is a breach too; so that the force after it is judged, it begins the record.
  const auto fault_first = [](Record& run) {
    fault(run);
    run.erase(run.begin(), run.begin() + kFaultTick);
  };
  expect_breach("fault", {fault}, 50, "fault DEVICE_SILENT");
  expect_breach("elastic force", {fault, set(50, &RecordedTick::tau_elastic, 1.0)}, 50,
                "elastic force in FAULT");
  expect_breach("gain", {fault, set(50, &RecordedTick::gain, 0.5)}, 50, "elastic force in FAULT");
  expect_breach("a command of another sign", {fault, set(50, &RecordedTick::tau_a, -9.0)}, 50,
                "force changed");
  expect_breach("no force", {fault_first});
  expect_breach("a command in the first tick", {fault_first, set(0, &RecordedTick::tau_a, 10.0)});
  expect_breach("a command in the second tick", {fault_first, set(1, &RecordedTick::tau_a, 10.0)},
                51, "a command of 10");
  expect_breach("a command later", {fault_first, set(40, &RecordedTick::tau_a, 0.1)}, 90,
                "a command of 0.1");
  expect_breach("a state with force", {fault_first, [](Record& r) { r[10].state = "ENGAGED"; }}, 60,
                "ENGAGED while");
  expect_breach("an end", {fault_first, [](Record& r) { r[49].state = "CLOSING"; }});
}

/// 1 N per tick, either way; a disarmed device drops all of it.
TEST(RunRecord, JudgesStepsOfForce) {
  expect_breach("allowed fall", {force_from(30, 9.1)});
  expect_breach("fall", {force_from(30, 5.0)}, 30, "force");
  expect_breach("fall to nothing", {force_from(30, 0.0)}, 30, "force");
  expect_breach("other sign", {force_from(30, -9.9)}, 30, "force");
  expect_breach("damping", {force_from(0, 10.0, -2.0), force_from(30, 10.0)}, 30, "force");
  expect_breach("disarmed", {disarmed});
  const auto armed = [](Record& run) {
    for (RecordedTick& tick : run) tick.state = "ARMED";
  };
  expect_breach("armed", {disarmed, armed}, 30, "force changed");
}

/// The envelope at an age of 172 ms is a tenth of 25 N.
TEST(RunRecord, EnvelopeMayTakeElasticForce) {
  const auto faded = fade_from(30, 0.172, "FADE");
  const auto lost = fade_from(30, 0.190, "LOST");
  const auto damped = force_from(0, 10.0, -2.0);
  const std::string step = "force changed";
  expect_breach("onto it", {faded, force_from(30, 2.5)});
  expect_breach("onto it, damping by less", {faded, force_from(30, 2.5, -0.9)});
  expect_breach("onto it, damping by more", {faded, force_from(30, 2.5, -1.1)}, 30, step);
  expect_breach("below it", {faded, force_from(30, 1.0)}, 30, step);
  expect_breach("to its other side", {faded, force_from(30, -2.5)}, 30, step);
  expect_breach("no gain, same damping", {damped, lost, force_from(30, 0.0, -2.0)});
  expect_breach("no gain, no damping", {damped, lost, force_from(30, 0.0)}, 30, step);
}

/// The gain may fall by a tick's share of 80 ms, or as the ladder does.
TEST(RunRecord, JudgesStepsOfGain) {
  expect_breach("allowed fall", {gain_from_30(0.988)});
  expect_breach("fall", {gain_from_30(0.986)}, 30, "gain fell");
  expect_breach("fall that takes the force", {gain_from_30(0.0), force_from(30, 0.0)}, 30,
                "gain fell");
  expect_breach("rise", {[](Record& run) { run[29].gain = 0.99; }}, 30, "gain rose");
}

/// 10 N along 10 mm are 0.1 J, 0.08 J after the device's damping; the tank held 0.05 J.
TEST(RunRecord, JudgesEnergyAgainstTheTank) {
  const auto pushed_along = [](Record& run) {
    for (std::size_t i = 20; i < kRecorded; ++i) {
      run[i].slide = 1e-3 * static_cast<double>(std::min<std::size_t>(i - 19, 10));
    }
  };
  Record run = pushing();
  pushed_along(run);
  EXPECT_NE(judge(run, kFreshUntil).breach.find("J given out"), std::string::npos);
}

}  // namespace
}  // namespace haptic::test
