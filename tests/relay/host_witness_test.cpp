/// The witness sees what takes a processor from above, and nothing that ours could do; and a row
/// tells the two from each other. Real time and real processors, for some milliseconds at a time:
/// label `network`.

#include "tests/relay/host_witness.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <latch>

#include "tests/relay/network_row.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

/// Takes every processor at once, at `priority`, for `time`: what a host does, from above the
/// witness; what ours may do, from below.
void take_all_processors(int priority, std::chrono::milliseconds time) {
  const std::vector<int> processors = own_processors();
  std::latch all(static_cast<std::ptrdiff_t>(processors.size()));
  std::vector<std::thread> takers;
  for (const int processor : processors) {
    takers.emplace_back([&all, processor, priority, time] {
      const bool taken = take_processor(processor, priority) == 0;
      all.arrive_and_wait();
      const auto until = std::chrono::steady_clock::now() + time;
      while (taken && std::chrono::steady_clock::now() < until) {
      }
    });
  }
  for (std::thread& taker : takers) taker.join();
}

/// s, the longest stall that ended after `since`.
double longest(const HostWitness& witness, std::chrono::steady_clock::time_point since) {
  double longest = 0.0;
  for (const Stall& stall : witness.testimony(since.time_since_epoch()).stalls) {
    if (stall.to > 0.0) longest = std::max(longest, stall.to - stall.from);
  }
  return longest;
}

class Witness : public testing::Test {
 protected:
  void SetUp() override {
    const std::string refusal = HostWitness().refusal();
    if (!refusal.empty()) GTEST_SKIP() << refusal;
  }
};

TEST_F(Witness, SeesAProcessorTakenFromAbove) {
  const HostWitness witness;
  std::this_thread::sleep_for(10ms);
  const auto before = std::chrono::steady_clock::now();
  take_all_processors(95, 12ms);
  std::this_thread::sleep_for(10ms);
  EXPECT_GT(longest(witness, before), 0.010);
}

TEST_F(Witness, IsNotMadeLateByTheLoopsPriority) {
  const HostWitness witness;
  std::this_thread::sleep_for(10ms);
  const auto before = std::chrono::steady_clock::now();
  take_all_processors(80, 200ms);
  std::this_thread::sleep_for(10ms);
  EXPECT_LT(longest(witness, before), 0.100);  // the host's own stalls are shorter than that
}

void press_for_a_while(RowRun& run, const std::function<void()>& trouble) {
  {
    Presser presser(run.daemon().address());
    std::this_thread::sleep_for(500ms);
    trouble();
    std::this_thread::sleep_for(200ms);
  }
  static_cast<void>(run.judge());
}

TEST_F(Witness, ALoopThatTheHostMadeLateHasAnExcuse) {
  const RunReport report = run_once([](RowRun& run) {
    press_for_a_while(run, [&] {
      take_all_processors(95, 15ms);
      std::this_thread::sleep_for(20ms);
      run.expect(false, "what comes after");
    });
  });
  ASSERT_EQ(report.findings.size(), 2U);  // and the fault
  ASSERT_TRUE(report.excuse) << report.findings.front().text() << ", " << report.witness;
  EXPECT_NE(report.excuse->find("host stalled"), std::string::npos);
}

TEST_F(Witness, WhatWasSeenBeforeTheHostTookTheProcessorsIsNotExcused) {
  const RunReport report = run_once([](RowRun& run) {
    press_for_a_while(run, [&] {
      run.expect(false, "what came before");
      std::this_thread::sleep_for(20ms);
      take_all_processors(95, 15ms);
    });
  });
  ASSERT_EQ(report.findings.size(), 2U);  // and the fault
  ASSERT_TRUE(report.findings.front().at && report.findings.back().at);
  EXPECT_LT(*report.findings.front().at, *report.findings.back().at);
  EXPECT_FALSE(report.excuse) << *report.excuse;
}

/// As a row that fails with that fault, in the first run that the host itself left alone.
TEST_F(Witness, ALoopThatWasLateByItselfHasNone) {
  const RowReport row = until_a_run_counts([] {
    return run_once([](RowRun& run) {
      press_for_a_while(run, [&] {
        run.daemon().signal(SIGSTOP);
        std::this_thread::sleep_for(100ms);  // longer than the host's own stalls
        run.daemon().signal(SIGCONT);
      });
    });
  });
  ASSERT_FALSE(row.failures.empty());
  EXPECT_NE(row.failures.front().find("LOOP_LATE"), std::string::npos) << row.failures.front();
}

}  // namespace
}  // namespace haptic::test
