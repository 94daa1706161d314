/// Round trip, clock and age from the samples themselves, on virtual time.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "server/front/session/link_watch.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;
using core::Duration;
using core::TimePoint;
using server::Carrier;
using server::LinkWatch;
using server::SampleStamp;

/// A client whose clock is off and which holds each state for a while; links of any delay.
class LinkWatchTest : public testing::Test {
 protected:
  static constexpr Duration kOffset = 1234567ms;
  Duration offset{kOffset};  ///< the client's clock may be stepped
  static constexpr Duration kHold = 4ms;
  static constexpr Duration kEachWay = 10ms;

  /// One state down and the sample computed from it up; when it left, by the server's clock.
  std::optional<server::Departure> exchange(Duration down, Duration up,
                                            Carrier carrier = Carrier::kGrpc) {
    watch.state_sent(++tick, now, carrier);
    left = now + down + kHold;
    SampleStamp stamp;
    stamp.carrier = carrier;
    stamp.bytes = 50;
    stamp.source_time_ns = (left.time_since_epoch() + offset).count();
    stamp.state_used = tick;
    stamp.hold = kHold;
    stamp.arrival = arrival = left + up;
    now += 16ms;
    return watch.came(stamp, std::nullopt);
  }
  void steady(int n) {
    for (int i = 0; i < n; ++i) static_cast<void>(exchange(kEachWay, kEachWay));
  }

  LinkWatch watch;
  TimePoint now{1h};
  TimePoint left{}, arrival{};
  std::uint64_t tick{0};
};

TEST_F(LinkWatchTest, RoundTripExcludesTheClientsHold) {
  steady(100);
  const wire::RoundTrip& rtt = watch.figures(Carrier::kGrpc).round_trip;
  EXPECT_EQ(rtt.least(), 2 * kEachWay);
  EXPECT_EQ(rtt.smoothed(), 2 * kEachWay);
  EXPECT_FALSE(watch.figures(Carrier::kUdp).round_trip.known());
}

TEST_F(LinkWatchTest, ClockOffsetLiesWithinItsBound) {
  std::mt19937 random(7);
  std::exponential_distribution<double> queue(1.0 / 3e6);  // ns, 3 ms on average
  for (int i = 0; i < 1000; ++i) {
    const auto late = [&] { return Duration(static_cast<std::int64_t>(queue(random))); };
    static_cast<void>(exchange(kEachWay + late(), kEachWay + late()));
    const auto estimate = watch.clock().at(wire::TimePoint(now.time_since_epoch()));
    ASSERT_TRUE(estimate);
    EXPECT_LE(std::chrono::abs(estimate->offset - kOffset), estimate->bound);
  }
}

TEST_F(LinkWatchTest, TravelTimeAgesASample) {
  steady(100);
  const auto usual = exchange(kEachWay, kEachWay);
  ASSERT_TRUE(usual);
  EXPECT_LT(arrival - usual->latest, 1ms);
  EXPECT_LT(std::chrono::abs(usual->likely - left), 1us) << "links that are alike both ways";
  const auto held_up = exchange(kEachWay, kEachWay + 50ms);
  ASSERT_TRUE(held_up);
  // All of the 50 ms but what the bound cannot tell: a drift of 500 ppm since the last proof.
  EXPECT_NEAR(core::seconds(arrival - held_up->latest), 0.050, 0.001);
  EXPECT_GE(held_up->latest, left);  // never older than it is
  EXPECT_LT(std::chrono::abs(held_up->likely - left), 1us);
  EXPECT_EQ(watch.aged(), 1U);
}

TEST_F(LinkWatchTest, AgeIsNeverExtendedNorOverstated) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> delay(0.0, 40e6);
  for (int i = 0; i < 2000; ++i) {
    const Duration down(static_cast<std::int64_t>(delay(random)));
    const Duration up(static_cast<std::int64_t>(delay(random)));
    const auto told = exchange(down, up, i % 3 == 0 ? Carrier::kUdp : Carrier::kGrpc);
    ASSERT_TRUE(told);
    EXPECT_LE(told->latest, arrival);
    EXPECT_GE(told->latest, left);
    EXPECT_LE(told->likely, told->latest);
  }
}

TEST_F(LinkWatchTest, UnknownClockUsesTheArrival) {
  SampleStamp stamp{.arrival = now};
  EXPECT_FALSE(watch.came(stamp, std::nullopt));
  stamp.source_time_ns = (now.time_since_epoch() + kOffset).count();
  EXPECT_FALSE(watch.came(stamp, std::nullopt)) << "nothing proves the offset yet";
}

TEST_F(LinkWatchTest, UsesTheTighterEstimate) {
  steady(100);
  wire::ClockOffset::Estimate path{.offset = kOffset, .bound = 1ms};
  watch.state_sent(++tick, now, Carrier::kGrpc);
  SampleStamp stamp{.source_time_ns = (now.time_since_epoch() + kEachWay + kOffset).count(),
                    .state_used = tick,
                    .arrival = now + 2 * kEachWay};
  const auto told = watch.came(stamp, path);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->latest, now + kEachWay + 1ms);
  EXPECT_EQ(told->likely, now + kEachWay);
}

TEST_F(LinkWatchTest, ClockStepMakesNoSampleOld) {
  for (const Duration step : {Duration(-1s), Duration(1s), Duration(-100ms)}) {
    steady(100);
    offset += step;
    for (int i = 0; i < 20; ++i) {
      const auto told = exchange(kEachWay, kEachWay);
      if (told) {
        EXPECT_LT(arrival - told->latest, 1ms);
      }
    }
    // And the estimate has begun anew: what is held up now is seen again.
    const auto held_up = exchange(kEachWay, kEachWay + 50ms);
    ASSERT_TRUE(held_up);
    EXPECT_NEAR(core::seconds(arrival - held_up->latest), 0.050, 0.001);
  }
  EXPECT_EQ(watch.clock().steps(), 3U);
}

TEST_F(LinkWatchTest, SampleWithoutExchangeUsesItsArrival) {
  steady(100);
  SampleStamp stamp{.source_time_ns = (now.time_since_epoch() + kOffset - 500ms).count(),
                    .arrival = now};
  EXPECT_FALSE(watch.came(stamp, std::nullopt));
}

TEST_F(LinkWatchTest, NonsenseFromAClientChangesNothing) {
  steady(100);
  using Limits = std::numeric_limits<std::int64_t>;
  for (const std::int64_t nonsense : {Limits::min(), std::int64_t{-1}, Limits::max()}) {
    SampleStamp stamp{.source_time_ns = nonsense, .state_used = tick, .arrival = now};
    EXPECT_FALSE(watch.came(stamp, std::nullopt)) << nonsense;
  }
  SampleStamp held_too_long{.source_time_ns = (now.time_since_epoch() + kOffset).count(),
                            .state_used = tick,
                            .hold = 1h,
                            .arrival = now};
  static_cast<void>(watch.came(held_too_long, std::nullopt));
  EXPECT_EQ(watch.figures(Carrier::kGrpc).round_trip.least(), 2 * kEachWay);
  EXPECT_EQ(watch.clock().steps(), 0U);
}

TEST_F(LinkWatchTest, CountsPerCarrier) {
  steady(10);
  now += 200ms;
  steady(1);
  static_cast<void>(exchange(kEachWay, kEachWay, Carrier::kUdp));
  watch.judged(Carrier::kGrpc, server::IngressVerdict::kNotFinite);
  watch.judged(Carrier::kGrpc, server::IngressVerdict::kAccepted);
  const server::CarrierFigures& stream = watch.figures(Carrier::kGrpc);
  EXPECT_EQ(stream.samples, 11U);
  EXPECT_EQ(stream.sample_bytes, 550U);
  EXPECT_EQ(stream.states, 11U);
  EXPECT_EQ(stream.longest_gap, 216ms);
  EXPECT_EQ(stream.jitter, 0ms);
  EXPECT_EQ(stream.rejected[static_cast<std::size_t>(server::IngressVerdict::kNotFinite)], 1U);
  EXPECT_EQ(stream.rejected[static_cast<std::size_t>(server::IngressVerdict::kAccepted)], 0U);
  EXPECT_EQ(watch.figures(Carrier::kUdp).samples, 1U);
}

}  // namespace
}  // namespace haptic::test
