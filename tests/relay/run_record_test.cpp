/// The judge of records finds the breach of each of its rules, and none in a good run. Limits are
/// those of proto/README.md#staleness-and-gain and of the scene (daemon.hpp).

#include "tests/relay/run_record.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

namespace haptic::test {
namespace {

constexpr double kFreshUntil = 0.025;  // s
constexpr int kFrom = 30;

using Record = std::vector<RecordedTick>;
using Change = std::function<void(RecordedTick&, int ticks_since)>;

/// 1 kHz, a proxy of 5 ms, a finger that stands still and is pushed with 10 N; changed from tick
/// kFrom on.
Record pushing(const Change& change) {
  Record run;
  for (int i = 0; i < 100; ++i) {
    RecordedTick tick{.time = 1e-3 * static_cast<double>(i),
                      .tick = static_cast<std::uint64_t>(i + 1),
                      .state = "ENGAGED",
                      .staleness = "FRESH",
                      .mode = "HELD",
                      .age = 0.005,
                      .gain = 1.0};
    tick.tau_elastic = tick.tau_a = 10.0;
    if (i >= kFrom) change(tick, i - kFrom);
    run.push_back(tick);
  }
  return run;
}

/// From kFrom on.
Change set(double RecordedTick::*field, double value) {
  return [=](RecordedTick& tick, int) { tick.*field = value; };
}

/// A fault, which takes the force after so many ticks.
Change fault(int after) {
  return [=](RecordedTick& tick, int since) {
    tick.state = "FAULT";
    tick.faults = "DEVICE_SILENT";
    tick.gain = tick.tau_elastic = 0.0;
    if (since >= after) tick.tau_a = 0.0;
  };
}

/// An old proxy, whose envelope is a tenth of 25 N, with this elastic force and no damping.
Change faded(double elastic) {
  return [=](RecordedTick& tick, int) {
    tick.age = 0.172;
    tick.staleness = "FADE";
    tick.gain = 0.1;
    tick.tau_elastic = tick.tau_a = elastic;
  };
}

TEST(RunRecord, FindsEachBreach) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto along = [](RecordedTick& tick, int since) {  // 0.08 J, and the tank held 0.05
    tick.slide = 1e-3 * static_cast<double>(std::min(since, 10));
  };
  const struct {
    const char* name;
    Change change;
    const char* breach;           ///< "": none
    std::ptrdiff_t begins_at{0};  ///< tick of the record
  } rows[]{
      {"nothing", [](RecordedTick&, int) {}, ""},
      {"allowed rise", set(&RecordedTick::tau_a, 10.9), ""},
      {"jump", set(&RecordedTick::tau_a, 11.1), "at 0.030000 s: force changed"},
      {"onto the envelope", faded(2.5), ""},
      {"below the envelope", faded(1.0), "force changed"},
      {"above the envelope", set(&RecordedTick::gain, 0.3), "elastic force above"},
      {"allowed fall of the gain", set(&RecordedTick::gain, 0.988), ""},
      {"fall of the gain", set(&RecordedTick::gain, 0.986), "gain fell"},
      {"rise of the gain", [](RecordedTick& tick, int i) { tick.gain = i < 2 ? 0.99 : 1.0; },
       "gain rose"},
      {"old, said fresh", set(&RecordedTick::age, 0.030), "FRESH at an age"},
      {"not a number", set(&RecordedTick::tau_a, kNan), "not a finite"},
      {"a tick twice", [](RecordedTick& tick, int) { --tick.tick; }, "a tick"},
      {"a fault", fault(0), "fault DEVICE_SILENT"},
      {"no command from the second tick of a fault on", fault(1), "", kFrom},
      {"a command in the second tick of a fault", fault(2), "a command of 10", kFrom},
      {"energy", along, "J given out"},
  };
  for (const auto& row : rows) {
    Record run = pushing(row.change);
    run.erase(run.begin(), run.begin() + row.begins_at);
    const std::string found = judge(run, kFreshUntil).breach;
    EXPECT_NE(found.find(row.breach), std::string::npos) << row.name << ": " << found;
    EXPECT_EQ(found.empty(), *row.breach == '\0') << row.name << ": " << found;
  }
}

}  // namespace
}  // namespace haptic::test
