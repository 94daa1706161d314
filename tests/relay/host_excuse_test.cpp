/// Which fault is the host's and which is ours, in tables; and which run counts.

#include "tests/relay/host_excuse.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace haptic::test {
namespace {

/// A loop of 1 kHz on time for `seconds`, but for ticks that were late.
class Run {
 public:
  explicit Run(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(1e3 * seconds)); ++i) {
      RecordedTick tick;
      tick.time = 1e-3 * i;
      tick.tick = static_cast<std::uint64_t>(i) + 1;
      tick.state = "ENGAGED";
      ticks_.push_back(tick);
    }
  }
  /// The deadline at `from` is met `lateness` later, and those in between not at all.
  Run& late(double from, double lateness) {
    const auto skipped = static_cast<std::size_t>(1e3 * lateness);
    const auto at = static_cast<std::ptrdiff_t>(index(from));
    RecordedTick& tick = ticks_.at(index(from));
    tick.time = from + lateness;
    tick.lateness = lateness;
    tick.skipped = static_cast<double>(skipped);
    ticks_.erase(ticks_.begin() + at + 1,
                 ticks_.begin() + at + 1 + static_cast<std::ptrdiff_t>(skipped));
    return *this;
  }
  /// Latched from the first tick at or after `time`.
  Run& fault(double time, const std::string& reasons) {
    for (std::size_t i = index(time); i < ticks_.size(); ++i) {
      ticks_[i].faults = reasons;
      ticks_[i].state = reasons.empty() ? "ENGAGED" : "FAULT";
    }
    return *this;
  }
  [[nodiscard]] const std::vector<RecordedTick>& ticks() const { return ticks_; }

 private:
  [[nodiscard]] std::size_t index(double time) const {
    std::size_t i = 0;
    while (ticks_.at(i).time < time - 1e-9) ++i;
    return i;
  }
  std::vector<RecordedTick> ticks_{};
};

/// 12 ms late at 0.5 s, which is a fault.
Run late_once() {
  return Run(1.0).late(0.5, 0.0121).fault(0.5, "LOOP_LATE");
}

struct Case {
  std::string name{};
  Run run;
  Testimony testimony{};
  std::optional<std::string> excuse{};
  std::vector<Finding> findings{};
};

std::vector<Case> single_lateness() {
  const std::optional<std::string> host = "host stalled 12 ms at 0.5 s", ours{};
  return {
      {"TheStallCoversTheLateness", late_once(), {true, {{0.4995, 0.512}}}, host},
      {"ItsEndMayBeLessThanAPeriodBeforeTheWakeUp", late_once(), {true, {{0.499, 0.5117}}}, host},
      {"TwoProcessorsTakeTurns", late_once(), {true, {{0.506, 0.512}, {0.499, 0.506}}}, host},
      {"OthersBeforeAndAfterDoNotMatter",
       late_once(),
       {true, {{0.1, 0.2}, {0.499, 0.512}, {0.8, 0.9}}},
       host},
      {"NoStallWasSeen", late_once(), {true, {}}, ours},
      {"TheStallIsBefore", late_once(), {true, {{0.48, 0.499}}}, ours},
      {"TheStallIsAfter", late_once(), {true, {{0.513, 0.53}}}, ours},
      {"TheStallIsTooShort", late_once(), {true, {{0.499, 0.510}}}, ours},
      {"TheSameStallOnTwoProcessorsIsOne",
       late_once(),
       {true, {{0.499, 0.506}, {0.499, 0.506}}},
       ours},
      {"TheWitnessWithoutItsPriority", late_once(), {false, {{0.499, 0.512}}}, ours},
      {"NoFault", Run(1.0).late(0.5, 0.0121), {true, {{0.499, 0.512}}}, ours},
      {"AnotherFault",
       Run(1.0).late(0.5, 0.0121).fault(0.5, "DEVICE_SILENT"),
       {true, {{0.499, 0.512}}},
       ours},
      {"AnotherFaultBesides",
       late_once().fault(0.7, "DEVICE_SILENT|LOOP_LATE"),
       {true, {{0.499, 0.512}}},
       ours},
      {"AnotherFaultBefore",
       late_once().fault(0.3, "DEVICE_SILENT").fault(0.5, "LOOP_LATE"),
       {true, {{0.499, 0.512}}},
       ours},
      {"ASecondOneOfOurs",
       Run(1.0)
           .late(0.5, 0.0121)
           .fault(0.5, "LOOP_LATE")
           .fault(0.6, "")
           .late(0.7, 0.0091)
           .fault(0.7, "LOOP_LATE"),
       {true, {{0.499, 0.512}}},
       ours},
      {"AFaultThatItsLatenessDoesNotBearOut",
       Run(1.0).late(0.5, 0.0071).fault(0.5, "LOOP_LATE"),
       {true, {{0.499, 0.507}}},
       ours},
  };
}

/// Beside an excused fault at 0.5121 s.
std::vector<Case> other_findings() {
  const auto with = [](const char* name, std::vector<Finding> findings, bool excused) {
    std::optional<std::string> excuse;
    if (excused) excuse = "host stalled 12 ms at 0.5 s";
    return Case{name, late_once(), {true, {{0.499, 0.512}}}, excuse, std::move(findings)};
  };
  const Finding fault{"fault LOOP_LATE", 0.5121}, not_engaged{"not engaged", 0.9};
  return {
      with("TheFaultItself", {fault}, true),
      with("WhatCameAfter", {fault, not_engaged}, true),
      with("WhatCameBefore", {{"UDP given up", 0.4}, fault}, false),
      with("WhatCameJustBefore", {{"UDP given up", 0.512}, fault}, false),
      with("OneBeforeAmongOthersAfter", {fault, not_engaged, {"UDP given up", 0.4}}, false),
      with("NobodyKnowsWhen", {fault, {"UDP given up", {}}}, false),
      with("TheDaemonCrashed", {fault, {"exit status", {}, true}}, false),
      with("ForceInTheVeryTick", {{"elastic force in FAULT", 0.5121, true}, fault}, false),
      with("ForceLeftOn", {fault, {"a command after a fault", 0.6, true}}, false),
      with("FinalAmongConsequences", {fault, not_engaged, {"seq went back", 0.8, true}}, false),
  };
}

/// Lags of 4.1 ms, 10 per second. Each skips 4 deadlines: +20, and with the 95 ticks on time until
/// the next one -4. The sixth fills the bucket, 20 + 5 x 16 = 100; the fifth does not, 84.
constexpr double kLag = 0.0041;

double lag_at(int i) {
  return 0.1 + 0.1 * i;
}

Run lagging() {
  Run run(1.0);
  for (int i = 0; i < 6; ++i) run.late(lag_at(i), kLag);
  return run.fault(lag_at(5), "LATE_BUCKET_FULL");
}

/// Of the lags numbered in `which`.
Testimony stalls_at(std::initializer_list<int> which) {
  Testimony testimony{true, {}};
  for (const int i : which) testimony.stalls.push_back({lag_at(i) - 0.0005, lag_at(i) + kLag});
  return testimony;
}

std::vector<Case> many_lags() {
  const std::optional<std::string> host = "host stalled 25 ms, 6 times, by 0.6 s", ours{};
  Testimony unheard = stalls_at({0, 1, 2, 3, 4, 5});
  unheard.above_all = false;
  Run not_full(1.0);
  for (int i = 0; i < 5; ++i) not_full.late(lag_at(i), kLag);
  not_full.fault(lag_at(4), "LATE_BUCKET_FULL");
  return {
      {"EachLagIsAStall", lagging(), stalls_at({0, 1, 2, 3, 4, 5}), host},
      // The first three alone: 52, and in the 300 ms since 14 less.
      {"OursAloneFillLessThanHalf", lagging(), stalls_at({3, 4, 5}),
       "host stalled 12 ms, 3 times, by 0.6 s"},
      // The first four: 68, and in the 200 ms since 9 less.
      {"OursAloneFillHalf", lagging(), stalls_at({4, 5}), ours},
      {"NoStallWasSeen", lagging(), {true, {}}, ours},
      {"StallsAtOtherTimes", lagging(), {true, {{0.15, 0.19}, {0.25, 0.29}, {0.8, 0.9}}}, ours},
      {"TheWitnessWithoutItsPriority", lagging(), unheard, ours},
      {"ABucketThatIsNotFull", not_full, stalls_at({0, 1, 2, 3, 4}), ours},
  };
}

void verdict_on(const std::vector<Case>& cases) {
  for (const Case& each : cases) {
    EXPECT_EQ(host_excuse(each.run.ticks(), each.testimony, each.findings), each.excuse)
        << each.name;
  }
}

TEST(HostExcuse, ALateTickIsTheHostsWhereAStallCoversItsLateness) {
  verdict_on(single_lateness());
}

TEST(HostExcuse, OnlyWhatMayBeItsConsequenceIsExcusedWithIt) {
  verdict_on(other_findings());
}

TEST(HostExcuse, AFullBucketIsTheHostsWhereStallsFilledIt) {
  verdict_on(many_lags());
}

/// 4 deadlines each, of `count` lags in 4 s; 0.5 % of the ticks that are left are 19.9.
Run lagging_in_4_s(int count) {
  Run run(4.0);
  for (int i = 0; i < count; ++i) run.late(lag_at(i), kLag);
  return run;
}

TEST(SkippedDeadlines, AreFewBesidesThoseThatStallsExplain) {
  const auto few = lagging_in_4_s(4), many = lagging_in_4_s(5);
  EXPECT_FALSE(too_many_skipped(few.ticks(), {true, {}}));
  EXPECT_EQ(too_many_skipped(many.ticks(), {true, {}}),
            "20 of 3980 deadlines skipped without a stall of the host");
  EXPECT_FALSE(too_many_skipped(many.ticks(), stalls_at({2})));
  EXPECT_FALSE(too_many_skipped(many.ticks(), stalls_at({0, 1, 2, 3, 4})));
  EXPECT_TRUE(too_many_skipped(many.ticks(), {true, {{0.15, 0.19}, {0.65, 0.9}}}));
  Testimony unheard = stalls_at({0, 1, 2, 3, 4});
  unheard.above_all = false;
  EXPECT_TRUE(too_many_skipped(many.ticks(), unheard));
}

RunReport fine() {
  return {{}, {"figures"}, {}, "no stall of the host"};
}
RunReport wrong() {
  return {{{"a step", 0.5}}, {"figures"}, {}, "no stall of the host"};
}
RunReport disturbed() {
  return {{{"fault LOOP_LATE", 0.5}}, {"figures"}, "host stalled 12 ms at 0.5 s", ""};
}

/// Runs that end as `reports` say, in this order; how many were done.
struct Script {
  std::vector<RunReport> reports;
  std::size_t done{0};
  RowReport play() {
    return until_a_run_counts([this] { return reports.at(done++); });
  }
};

TEST(CountingRun, TheFirstUndisturbedOneCounts) {
  Script script{{fine(), wrong()}};
  const RowReport row = script.play();
  EXPECT_EQ(script.done, 1U);
  EXPECT_TRUE(row.failures.empty());
  EXPECT_EQ(row.got, (std::vector<std::string>{"figures", "run 1, no stall of the host"}));
}

TEST(CountingRun, AFailureOfOursIsFinal) {
  Script script{{wrong(), fine()}};
  const RowReport row = script.play();
  EXPECT_EQ(script.done, 1U);
  ASSERT_EQ(row.failures.size(), 1U);
  EXPECT_NE(row.failures[0].find("a step"), std::string::npos);
}

TEST(CountingRun, ADisturbedOneIsDoneAgainAndTold) {
  Script script{{disturbed(), fine()}};
  const RowReport row = script.play();
  EXPECT_EQ(script.done, 2U);
  EXPECT_TRUE(row.failures.empty());
  EXPECT_EQ(row.got.back(), "run 1: host stalled 12 ms at 0.5 s");
}

TEST(CountingRun, WhatFailsAfterADisturbedOneFails) {
  Script script{{disturbed(), wrong(), fine()}};
  EXPECT_EQ(script.play().failures.size(), 1U);
  EXPECT_EQ(script.done, 2U);
}

TEST(CountingRun, AfterFiveDisturbedOnesTheRowFails) {
  Script script{{disturbed(), disturbed(), disturbed(), disturbed(), disturbed(), fine()}};
  const RowReport row = script.play();
  EXPECT_EQ(script.done, 5U);
  EXPECT_EQ(row.failures, (std::vector<std::string>{"host: none of 5 runs was undisturbed"}));
  EXPECT_EQ(row.got.size(), 6U);
}

}  // namespace
}  // namespace haptic::test
