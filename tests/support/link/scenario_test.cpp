#include "tests/support/link/scenario.hpp"

#include <gtest/gtest.h>

#include <set>

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

std::string refusal(const std::string& text) {
  try {
    static_cast<void>(parse_scenario(text, "s"));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Scenario, EveryFieldIsRead) {
  const Scenario s = parse_scenario(
      R"(what: "all of it" seed: 9 duration_s: 2.5
         up { delay_ms: 10 jitter_sigma_ms: 1.5 keep_order: true loss: 0.1
              burst { every_ms: 1000 length_ms: 8 } reorder: 0.25 reorder_by_ms: 15 duplicate: 1
              partition { from_s: 1 to_s: 1.1 carrier: CARRIER_UDP } stall { from_s: 2 to_s: 3 }
              rate_kbit_s: 8 queue_bytes: 500 }
         down { delay_ms: 20 }
         client_clock { drift_ppm: 200 step { at_s: 1 by_s: -1 } })",
      "s");
  EXPECT_EQ(s.name, "s");
  EXPECT_EQ(s.what, "all of it");
  EXPECT_EQ(s.seed, 9U);
  EXPECT_EQ(s.duration, 2500ms);
  EXPECT_EQ(s.up.delay, 10ms);
  EXPECT_EQ(s.up.jitter_sigma, 1500us);
  EXPECT_TRUE(s.up.keep_order);
  EXPECT_EQ(s.up.loss, 0.1);
  ASSERT_EQ(s.up.bursts.size(), 1U);
  EXPECT_EQ(s.up.bursts[0].every, 1s);
  EXPECT_EQ(s.up.bursts[0].length, 8ms);
  EXPECT_EQ(s.up.reorder, 0.25);
  EXPECT_EQ(s.up.reorder_by, 15ms);
  EXPECT_EQ(s.up.duplicate, 1.0);
  ASSERT_EQ(s.up.partitions.size(), 1U);
  EXPECT_TRUE(s.up.partitions[0].holds(1s, Carrier::kUdp));
  EXPECT_FALSE(s.up.partitions[0].holds(1100ms, Carrier::kUdp));
  EXPECT_FALSE(s.up.partitions[0].holds(1s, Carrier::kTcp));
  ASSERT_EQ(s.up.stalls.size(), 1U);
  EXPECT_TRUE(s.up.stalls[0].holds(2s, Carrier::kTcp));
  EXPECT_EQ(s.up.bytes_per_second, 1000.0);
  EXPECT_EQ(s.up.queue_bytes, 500.0);
  EXPECT_EQ(s.down.delay, 20ms);
  EXPECT_NEAR(s.client_clock.drift, 200e-6, 1e-12);
  ASSERT_EQ(s.client_clock.steps.size(), 1U);
  EXPECT_EQ(s.client_clock.steps[0].by, -1s);
}

TEST(Scenario, WhatIsOffIsRefusedByItsName) {
  const std::string good = R"(what: "x" duration_s: 1 )";
  EXPECT_EQ(refusal(good), "accepted");
  const std::pair<const char*, const char*> cases[] = {
      {"up { loss: 1.5 }", "s: up.loss = 1.5: must be 0..1"},
      {"down { loss: -0.1 }", "s: down.loss = -0.1: must be 0..1"},
      {"up { delay_ms: -1 }", "s: up.delay_ms = -1: must be >= 0"},
      {"up { delay_ms: nan }", "s: up.delay_ms = nan: must be >= 0"},
      {"up { duplicate: 2 }", "s: up.duplicate = 2: must be 0..1"},
      {"up { burst { every_ms: 5 } }", "s: up.burst.length_ms = 0: must be > 0"},
      {"up { partition { from_s: 2 to_s: 2 } }", "s: up.partition.to_s = 2: must be above from_s"},
      {"up { rate_kbit_s: 5 }", "s: up.queue_bytes = 0: must be > 0 where there is a rate"},
      {"nonsense: 1", "s: not a Scenario"}};
  for (const auto& [text, expected] : cases) EXPECT_EQ(refusal(good + text), expected);
  EXPECT_EQ(refusal("duration_s: 1"), "s: what: is missing");
  EXPECT_EQ(refusal(R"(what: "x")"), "s: duration_s = 0: must be > 0");
}

TEST(Scenario, EveryNetworkRowOfTheWireIsShippedUnderASeedOfItsOwn) {
  std::set<std::string> names;
  std::set<std::uint64_t> seeds;
  for (const Scenario& scenario : shipped_scenarios()) {
    names.insert(scenario.name);
    seeds.insert(scenario.seed);
  }
  for (const char* row : {"delay_1ms",
                          "delay_10ms",
                          "delay_30ms",
                          "delay_100ms",
                          "jitter_1ms",
                          "jitter_5ms",
                          "jitter_20ms",
                          "jitter_1ms_in_order",
                          "jitter_5ms_in_order",
                          "jitter_20ms_in_order",
                          "loss_01",
                          "loss_05",
                          "loss_10",
                          "loss_30",
                          "burst_8ms",
                          "burst_50ms",
                          "burst_200ms",
                          "reorder_25",
                          "duplicate_100",
                          "partition_100ms_up",
                          "partition_100ms_down",
                          "partition_1s_up",
                          "partition_1s_down",
                          "partition_10s_up",
                          "partition_10s_down",
                          "udp_blocked",
                          "tcp_blocked",
                          "clock_step_forward",
                          "clock_step_back",
                          "clock_drift",
                          "stall_backlog"}) {
    EXPECT_TRUE(names.count(row)) << row;
  }
  EXPECT_EQ(seeds.size(), names.size());
}

}  // namespace
}  // namespace haptic::test
