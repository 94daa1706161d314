#include <gtest/gtest.h>

#include "server/owner/ingress/ingress.hpp"

namespace haptic::server {
namespace {

using namespace std::chrono_literals;
using core::Duration;
using core::TimePoint;

constexpr Duration kPeriod = 16ms;  // of a 62.5 Hz client
const TimePoint kStart{1h};

TEST(Backlog, PunctualStreamIsAlwaysFresh) {
  BacklogRule rule(kPeriod);
  for (int i = 0; i < 1000; ++i) {
    const TimePoint t = kStart + i * kPeriod;
    const auto answer = rule.step(t);
    EXPECT_FALSE(answer.backlog);
    EXPECT_EQ(answer.born, t);
  }
}

TEST(Backlog, ToleratesHalfAPeriodsJitter) {
  BacklogRule rule(kPeriod);
  for (int i = 0; i < 1000; ++i) {
    const TimePoint t = kStart + i * kPeriod + (i % 2 == 0 ? 0ms : 8ms);
    EXPECT_FALSE(rule.step(t).backlog) << i;
  }
}

TEST(Backlog, OnePeriodLateIsStillFresh) {
  BacklogRule rule(kPeriod);
  static_cast<void>(rule.step(kStart));
  const TimePoint t = kStart + 2 * kPeriod;
  EXPECT_EQ(rule.step(t).born, t);
  EXPECT_EQ(rule.step(t).born, t);
  EXPECT_EQ(rule.step(t + kPeriod).born, t + kPeriod);
}

TEST(Backlog, BurstAfterStallKeepsItsAge) {
  BacklogRule rule(kPeriod);
  TimePoint before = kStart;
  for (int i = 0; i < 50; ++i) static_cast<void>(rule.step(before = kStart + i * kPeriod));
  const TimePoint burst = before + 150ms;
  BacklogRule::Answer answer;
  for (int i = 0; i < 9; ++i) answer = rule.step(burst + i * 100us);
  EXPECT_TRUE(answer.backlog);
  EXPECT_EQ(answer.born, before);
}

TEST(Backlog, NormalRateIsFreshAgain) {
  BacklogRule rule(kPeriod);
  static_cast<void>(rule.step(kStart));
  TimePoint t = kStart + 500ms;
  for (int i = 0; i < 30; ++i) static_cast<void>(rule.step(t));
  t += kPeriod;
  EXPECT_EQ(rule.step(t).born, t);
}

TEST(Backlog, SlowlyDrainedBacklogStaysOld) {
  BacklogRule rule(kPeriod);
  static_cast<void>(rule.step(kStart));
  TimePoint t = kStart + 500ms;
  for (int i = 0; i < 40; ++i) {
    const auto answer = rule.step(t += 3ms);  // five times the nominal rate
    if (i >= 5) {
      EXPECT_EQ(answer.born, kStart) << i;
    }
  }
}

TEST(Backlog, TooFastClientIsSoonOld) {
  BacklogRule rule(kPeriod);
  TimePoint t = kStart;
  int fresh = 0;
  for (int i = 0; i < 1000; ++i) fresh += rule.step(t += 5ms).backlog ? 0 : 1;
  EXPECT_LT(fresh, 10);
}

TEST(Backlog, CountsATooFastClientsRate) {
  BacklogRule rule(std::chrono::nanoseconds(16'666'667));
  TimePoint t = kStart;
  const auto stream = [&](Duration period, Duration length) {
    for (const TimePoint end = t + length; t < end; t += period) static_cast<void>(rule.step(t));
    return rule.too_fast();
  };
  EXPECT_EQ(stream(9ms, 3s).comes_hz, 0.0);
  const core::StreamRate rate = stream(2ms, 1500ms);
  EXPECT_EQ(rate.comes_hz, 500.0);
  EXPECT_NEAR(rate.announced_hz, 60.0, 1e-5);
  EXPECT_EQ(stream(16ms, 2s).comes_hz, 0.0) << "fresh again";
  t += 400ms;
  EXPECT_EQ(stream(100us, 3ms).comes_hz, 0.0) << "a burst after a stall is no rate";
}

TEST(Backlog, ClumpsDoNotAddUp) {
  // 1 kHz over a link that delivers 20 samples at once every 20 ms.
  BacklogRule rule(1ms);
  TimePoint t = kStart;
  for (int group = 0; group < 100; ++group) {
    t += 20ms;
    for (int i = 0; i < 20; ++i) {
      EXPECT_LE(t - rule.step(t).born, 20ms) << "group " << group;
    }
  }
}

TEST(Backlog, BusyHostsClumpIsFresh) {
  BacklogRule rule(1ms);
  static_cast<void>(rule.step(kStart));
  const TimePoint t = kStart + 6ms;
  for (int i = 0; i < 6; ++i) EXPECT_FALSE(rule.step(t).backlog);
}

}  // namespace
}  // namespace haptic::server
