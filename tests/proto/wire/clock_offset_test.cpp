#include "haptic/wire/clock_offset.hpp"

#include <gtest/gtest.h>

#include <random>

namespace haptic::wire {
namespace {

using namespace std::chrono_literals;

/// Their clock as a function of ours, and a link with queues on both ways.
struct World {
  Duration offset{0};
  double drift{0.0};
  Duration least{5ms};
  double queue_ms{0.0};  ///< mean of an exponential on each way
  std::mt19937 random{5};

  [[nodiscard]] Duration theirs(TimePoint ours) const {
    const auto ns = static_cast<double>(ours.time_since_epoch().count());
    return ours.time_since_epoch() + offset + Duration(static_cast<std::int64_t>(drift * ns));
  }
  Duration way() {
    if (queue_ms == 0.0) return least;
    std::exponential_distribution<double> queue(1.0 / queue_ms);
    return least + Duration(static_cast<std::int64_t>(queue(random) * 1e6));
  }
  ClockExchange exchange(TimePoint when) {
    const TimePoint came = when + way(), left = came + 1ms;
    return {when, theirs(came), theirs(left), left + way()};
  }
  /// The true offset at a time.
  [[nodiscard]] Duration truth(TimePoint ours) const {
    return theirs(ours) - ours.time_since_epoch();
  }
};

TEST(ClockOffset, SymmetricExchangeGivesTheOffset) {
  World world;
  world.offset = -77s;
  ClockOffset clock;
  clock.add(world.exchange(TimePoint(100s)));
  const auto estimate = clock.at(TimePoint(100s));
  ASSERT_TRUE(estimate);
  EXPECT_EQ(estimate->offset, -77s);
  EXPECT_NEAR(static_cast<double>(estimate->bound.count()), 5e6, 1e4);  // half of 10 ms
}

TEST(ClockOffset, IgnoresAnImpossibleExchange) {
  ClockOffset clock;
  clock.add({TimePoint(10s), 10s, 9s, TimePoint(11s)});   // answered before it came
  clock.add({TimePoint(10s), 10s, 13s, TimePoint(11s)});  // took longer there than here
  EXPECT_FALSE(clock.at(TimePoint(11s)));
}

TEST(ClockOffset, ShortestRoundTripCounts) {
  ClockOffset clock;
  const auto asymmetric = [](TimePoint when, Duration out, Duration back) {
    return ClockExchange{when, (when + out).time_since_epoch(), (when + out).time_since_epoch(),
                         when + out + back};
  };
  clock.add(asymmetric(TimePoint(100s), 41ms, 1ms));  // says +20 ms
  clock.add(asymmetric(TimePoint(100s + 100ms), 1ms, 1ms));
  clock.add(asymmetric(TimePoint(100s + 200ms), 1ms, 31ms));
  EXPECT_EQ(clock.at(TimePoint(100s + 300ms))->offset, 0ns);
}

TEST(ClockOffset, BoundHoldsThroughQueuesAndDrift) {
  for (const double drift : {0.0, 200e-6, -200e-6}) {
    World world;
    world.offset = 3s;
    world.drift = drift;
    world.queue_ms = 8.0;
    ClockOffset clock;
    for (TimePoint t(100s); t < TimePoint(160s); t += 20ms) {
      clock.add(world.exchange(t));
      const TimePoint later = t + 50ms;
      const auto estimate = clock.at(later);
      ASSERT_TRUE(estimate);
      ASSERT_LE(std::chrono::abs(estimate->offset - world.truth(later)), estimate->bound);
    }
    EXPECT_EQ(clock.steps(), 0U);
  }
}

TEST(ClockOffset, FindsADriftOf200Ppm) {
  World world;
  world.drift = 200e-6;
  world.queue_ms = 4.0;
  ClockOffset clock;
  for (TimePoint t(100s); t < TimePoint(130s); t += 20ms) clock.add(world.exchange(t));
  const auto estimate = clock.at(TimePoint(130s));
  EXPECT_NEAR(estimate->drift, 200e-6, 50e-6);
  // Half a millisecond of error where single exchanges are off by 4 ms and more.
  EXPECT_NEAR(static_cast<double>((estimate->offset - world.truth(TimePoint(130s))).count()), 0.0,
              0.5e6);
}

TEST(ClockOffset, StepRestartsAfterThreeExchanges) {
  for (const Duration step : {Duration(1s), Duration(-1s)}) {
    World world;
    ClockOffset clock;
    for (TimePoint t(100s); t < TimePoint(110s); t += 20ms) clock.add(world.exchange(t));
    world.offset = step;
    TimePoint t(110s);
    for (int i = 0; i < 2; ++i, t += 20ms) {
      clock.add(world.exchange(t));
      EXPECT_EQ(clock.at(t)->offset, 0ns);
    }
    clock.add(world.exchange(t));
    EXPECT_EQ(clock.at(t)->offset, step);
    EXPECT_EQ(clock.steps(), 1U);
  }
}

TEST(ClockOffset, OneWrongExchangeIsNoStep) {
  World world;
  ClockOffset clock;
  for (TimePoint t(100s); t < TimePoint(110s); t += 20ms) {
    ClockExchange exchange = world.exchange(t);
    if (t == TimePoint(105s)) exchange.received += 10s, exchange.answered += 10s;
    clock.add(exchange);
  }
  EXPECT_EQ(clock.at(TimePoint(110s))->offset, 0ns);
  EXPECT_EQ(clock.steps(), 0U);
}

}  // namespace
}  // namespace haptic::wire
