/// The judge of records, in tables: a good run, and what is wrong with one in which something was
/// changed. Limits are proto/README.md#staleness-and-gain's and the scene's (daemon.hpp).

#include "tests/relay/run_record.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace haptic::test {
namespace {

constexpr double kFreshUntil = 0.025;  // s
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kRecorded = 100, kFaultTick = 50;

using Record = std::vector<RecordedTick>;

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

/// The same, and LOOP_LATE from the 50th tick on, which takes the force.
Record faulted() {
  Record run = pushing();
  for (std::size_t i = kFaultTick; i < kRecorded; ++i) {
    run[i].state = "FAULT";
    run[i].faults = "LOOP_LATE";
    run[i].gain = run[i].tau_elastic = run[i].tau_a = 0.0;
  }
  return run;
}

struct JudgedRecord {
  std::string name{};
  Record run{};
  std::function<void(Record&)> change{};
  std::vector<std::string> breaches{};  ///< "final at 50: elastic", "at 50: fault", by their words
};

std::string words_of(const Finding& finding) {
  const auto tick = std::lround(1e3 * finding.at.value_or(-1.0));
  return (finding.is_final ? "final at " : "at ") + std::to_string(tick) + ": " + finding.what;
}

void expect_breaches(const std::vector<JudgedRecord>& cases) {
  for (JudgedRecord each : cases) {
    if (each.change) each.change(each.run);
    const std::vector<Finding> found = judge(each.run, kFreshUntil).breaches;
    ASSERT_EQ(found.size(), each.breaches.size()) << each.name;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(words_of(found[i]).substr(0, each.breaches[i].size()), each.breaches[i])
          << each.name;
    }
  }
}

TEST(RunRecord, WhatNoLatenessExplainsIsFinal) {
  expect_breaches({
      {"Nothing", pushing(), {}, {}},
      {"AForceThatJumps", pushing(), [](Record& r) { r[30].tau_a = 11.1; }, {"final at 30: force"}},
      {"AForceThatMayRiseSo", pushing(), [](Record& r) { r[30].tau_a = 10.9; }, {}},
      {"AboveTheEnvelope",
       pushing(),
       [](Record& r) { r[30].gain = 0.3; },
       {"final at 30: elastic force above"}},
      {"ForceFromNoGain", pushing(), [](Record& r) { r[30].gain = 0.0; }, {"final at 30: elastic"}},
      {"AnOldProxyCalledFresh",
       pushing(),
       [](Record& r) { r[30].age = 0.030; },
       {"final at 30: FRESH at an age"}},
      {"NaN",
       pushing(),
       [](Record& r) { r[30].tau_a = kNotANumber; },
       {"final at 30: not a finite"}},
      {"ATickTwice", pushing(), [](Record& r) { r[30].tick = 30; }, {"final at 30: a tick"}},
      {"AClockThatStands",
       pushing(),
       [](Record& r) { r[30].time = r[29].time; },
       {"final at 29: a tick"}},
  });
}

TEST(RunRecord, InAFaultNoForceIsLeft) {
  const std::string fault = "at 50: fault LOOP_LATE";
  expect_breaches({
      {"NoneIs", faulted(), {}, {fault}},
      {"ElasticForceInTheVeryTick",
       faulted(),
       [](Record& r) { r[50].tau_elastic = 1.0; },
       {"final at 50: elastic force in FAULT", fault}},
      {"GainInTheVeryTick",
       faulted(),
       [](Record& r) { r[50].gain = 0.5; },
       {"final at 50: elastic force in FAULT", fault}},
      // The command may take two ticks.
      {"ACommandInTheVeryTick", faulted(), [](Record& r) { r[50].tau_a = 10.0; }, {fault}},
      {"ACommandInTheSecondTick",
       faulted(),
       [](Record& r) { r[50].tau_a = r[51].tau_a = 10.0; },
       {fault, "final at 51: a command of 10"}},
      {"ACommandLeftOnThroughout",
       faulted(),
       [](Record& r) {
         for (std::size_t i = kFaultTick; i < kRecorded; ++i) r[i].tau_a = 0.5;
       },
       {fault, "final at 51: a command of 0.5"}},
      {"ForceThatComesBackLater",
       faulted(),
       [](Record& r) { r[90].tau_a = 0.1; },
       {fault, "final at 90: a command of 0.1"}},
      {"AFaultThatDoesNotStop",
       faulted(),
       [](Record& r) { r[60].state = "ENGAGED"; },
       {fault, "final at 60: ENGAGED while"}},
      {"AnEndInAFault", faulted(), [](Record& r) { r[99].state = "CLOSING"; }, {fault}},
  });
}

/// From `first` on: what the elastic part and the damping are.
void force_from(Record& r, std::size_t first, double elastic, double damping = 0.0) {
  for (std::size_t i = first; i < kRecorded; ++i) {
    r[i].tau_elastic = elastic;
    r[i].tau_a = elastic + damping;
  }
}

/// The same with the ladder's gain at that age, and the level.
void fade_from(Record& r, std::size_t first, double age, const std::string& level) {
  for (std::size_t i = first; i < kRecorded; ++i) {
    r[i].age = age;
    r[i].staleness = level;
    r[i].gain = level == "FADE" ? (0.180 - age) / 0.080 : 0.0;
  }
}

/// 1 N per tick, either way.
TEST(RunRecord, AForceThatStepsIsFinal) {
  expect_breaches({
      {"AFallAsItMay", pushing(), [](Record& r) { force_from(r, 30, 9.1); }, {}},
      {"AFall", pushing(), [](Record& r) { force_from(r, 30, 5.0); }, {"final at 30: force"}},
      {"AFallToNothing",
       pushing(),
       [](Record& r) { force_from(r, 30, 0.0); },
       {"final at 30: force"}},
      {"AnotherSign",
       pushing(),
       [](Record& r) { force_from(r, 30, -9.9); },
       {"final at 30: force"}},
      {"DampingThatFalls",
       pushing(),
       [](Record& r) {
         force_from(r, 0, 10.0, -2.0);
         force_from(r, 30, 10.0);
       },
       {"final at 30: force"}},
  });
}

/// The envelope at an age of 172 ms is a tenth of 25 N.
TEST(RunRecord, TheEnvelopeTakesElasticForceBeyondTheSlewLimit) {
  const auto at_172_ms = [](double elastic, double damping) {
    return [=](Record& r) {
      fade_from(r, 30, 0.172, "FADE");
      force_from(r, 30, elastic, damping);
    };
  };
  const auto lost = [](double damping) {
    return [=](Record& r) {
      force_from(r, 0, 10.0, -2.0);
      fade_from(r, 30, 0.190, "LOST");
      force_from(r, 30, 0.0, damping);
    };
  };
  const std::string step = "final at 30: force changed";
  expect_breaches({
      {"OntoIt", pushing(), at_172_ms(2.5, 0.0), {}},
      {"OntoItAndADampingThatMayRiseSo", pushing(), at_172_ms(2.5, -0.9), {}},
      {"OntoItAndADampingThatSteps", pushing(), at_172_ms(2.5, -1.1), {step}},
      {"BelowIt", pushing(), at_172_ms(1.0, 0.0), {step}},
      {"ToItsOtherSide", pushing(), at_172_ms(-2.5, 0.0), {step}},
      {"AllOfItWithoutGain", pushing(), lost(-2.0), {}},  // and what is left points the other way
      {"AllOfItWithoutGainAndADampingThatSteps", pushing(), lost(0.0), {step}},
  });
}

/// By a tick's share of 80 ms, or as the ladder does.
TEST(RunRecord, AGainThatStepsIsFinal) {
  const auto gain_from_30 = [](double gain) {
    return [=](Record& r) {
      for (std::size_t i = 30; i < kRecorded; ++i) r[i].gain = gain;
    };
  };
  expect_breaches({
      {"AFallAsItMay", pushing(), gain_from_30(0.988), {}},
      {"AFall", pushing(), gain_from_30(0.986), {"final at 30: gain fell"}},
      {"AFallThatTakesTheForce",
       pushing(),
       [&](Record& r) {
         gain_from_30(0.0)(r);
         force_from(r, 30, 0.0);
       },
       {"final at 30: gain fell"}},
      {"ARise", pushing(), [](Record& r) { r[29].gain = 0.99; }, {"final at 30: gain rose"}},
  });
}

TEST(RunRecord, AFaultAndADisarmedDeviceTakeAllForceAndTurnNone) {
  const std::string fault = "at 50: fault LOOP_LATE";
  const auto idle = [](Record& r) {
    fade_from(r, 0, 0.190, "LOST");
    force_from(r, 0, 0.0, -5.0);
    for (std::size_t i = 30; i < kRecorded; ++i) r[i].state = "IDLE";
    force_from(r, 30, 0.0);
  };
  expect_breaches({
      {"AFault", faulted(), {}, {fault}},
      {"APartInTheVeryTick", faulted(), [](Record& r) { r[50].tau_a = 5.0; }, {fault}},
      {"AnotherSignInTheVeryTick",
       faulted(),
       [](Record& r) { r[50].tau_a = -9.0; },
       {"final at 50: force changed", fault}},
      {"DampingOfADeviceNoLongerArmed", pushing(), idle, {}},
      {"DampingOfAnArmedOne",
       pushing(),
       [&](Record& r) {
         idle(r);
         for (RecordedTick& tick : r) tick.state = "ARMED";
       },
       {"final at 30: force changed"}},
  });
}

/// 10 N along 10 mm are 0.1 J, 0.08 J without what the damping takes; the tank held 0.05 J.
TEST(RunRecord, EnergyDoesNotHideWhatComesAfter) {
  const auto pushed = [](Record& r) {
    for (std::size_t i = 20; i < kRecorded; ++i) {
      r[i].slide = 1e-3 * static_cast<double>(std::min<std::size_t>(i - 19, 10));
    }
    r[70].tau_a = 12.0;
  };
  const RunFigures figures = [&] {
    Record run = pushing();
    pushed(run);
    return judge(run, kFreshUntil);
  }();
  ASSERT_EQ(figures.breaches.size(), 2U);
  EXPECT_FALSE(figures.breaches[0].is_final);
  EXPECT_NE(figures.breaches[0].what.find("J given out"), std::string::npos);
  EXPECT_EQ(words_of(figures.breaches[1]).substr(0, 18), "final at 70: force");
}

TEST(RunRecord, ALossHasItsTime) {
  Record run = pushing();
  EXPECT_FALSE(judge(run, kFreshUntil).last_loss);
  for (std::size_t i = 40; i < kRecorded; ++i) {
    run[i].state = "ARMED";
    run[i].gain = run[i].tau_elastic = run[i].tau_a = 0.0;
  }
  const RunFigures figures = judge(run, kFreshUntil);
  EXPECT_EQ(figures.losses, 1);
  ASSERT_TRUE(figures.last_loss);
  EXPECT_DOUBLE_EQ(*figures.last_loss, 0.040);
}

}  // namespace
}  // namespace haptic::test
