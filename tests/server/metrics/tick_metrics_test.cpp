#include "server/metrics/tick_metrics.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/server/support/device_rig.hpp"

namespace haptic::server {
namespace {

using test::DeviceRig;

struct MeteredRig : DeviceRig {
  MeteredRig() { telemetry->add(0, &metrics); }
  ~MeteredRig() { telemetry->remove(0, &metrics); }
  TickMetrics metrics{[this] { return sessions->ingress().carrier(); }};
};

std::uint64_t all(const Histogram& h) {
  return std::accumulate(h.counts().begin(), h.counts().end(), std::uint64_t{0});
}

TEST(TickMetrics, ResidenceIsTheTimeAtEachLevelOfALease) {
  MeteredRig rig;
  rig.tick(50);  // nobody controls: no level is counted
  EXPECT_EQ(rig.metrics.totals().level_s, (std::array<double, 4>{}));
  rig.control();
  const double before = rig.metrics.totals().level_s[3];  // LOST until the first sample
  for (int i = 0; i < 100; ++i) {
    rig.publish(0.0);
    rig.tick();
  }
  rig.tick(300);  // silence: 5 ms fresh at 1 kHz, hold to 100 ms, fade to 180 ms, lost after
  const TickTotals totals = rig.metrics.totals();
  const double tick = 1e-3;
  // A sample is published between ticks and is 1 ms old at the next: ages 1..5 ms, half-open.
  EXPECT_NEAR(totals.level_s[0], 0.104, 1.5 * tick);
  EXPECT_NEAR(totals.level_s[1], 0.095, 1.5 * tick);
  EXPECT_NEAR(totals.level_s[2], 0.080, 1.5 * tick);
  EXPECT_NEAR(totals.level_s[3] - before, 0.121, 2.5 * tick);
}

TEST(TickMetrics, EveryTickCountsOnceAndAgesOnlyWithAProxy) {
  MeteredRig rig;
  rig.tick(20);
  EXPECT_EQ(all(rig.metrics.totals().age), 0u);
  EXPECT_EQ(all(rig.metrics.totals().lateness), 20u);
  EXPECT_EQ(all(rig.metrics.totals().period), 19u);  // between two ticks
  EXPECT_NEAR(rig.metrics.totals().period.sum(), 0.019, 1e-9);
  rig.control();
  const std::uint64_t ages = all(rig.metrics.totals().age);
  rig.publish(0.0);
  rig.tick(7);
  EXPECT_EQ(all(rig.metrics.totals().age) - ages, 7u);
}

TEST(TickMetrics, ASamplesAgeIsThatOfTheNewestOneAlsoWhereATickHasNone) {
  TickMetrics metrics([] { return Carrier::kNone; });
  core::TickRecord record;
  record.input.now = core::TimePoint(std::chrono::seconds(5));
  metrics.on_record(record);
  EXPECT_EQ(all(metrics.totals().sample_age), 0u) << "no sample came so far";
  record.input.device.sample.seq = 1;
  record.input.device.sample.time = record.input.now - std::chrono::microseconds(1600);
  metrics.on_record(record);
  record.input.now += std::chrono::milliseconds(1);
  metrics.on_record(record);
  const Histogram age = metrics.totals().sample_age;
  EXPECT_EQ(all(age), 2u);
  EXPECT_NEAR(age.sum(), 0.0016 + 0.0026, 1e-9);
}

TEST(TickMetrics, AFaultCountsWhenItLatchesNotForAsLongAsItLasts) {
  MeteredRig rig;
  rig.tick(5);
  core::TickRecord record = rig.newest();
  record.life.faults.set(core::Fault::kEmergencyStop);
  for (int i = 0; i < 10; ++i) rig.metrics.on_record(record);
  record.life.faults = {};
  rig.metrics.on_record(record);
  record.life.faults.set(core::Fault::kEmergencyStop);
  rig.metrics.on_record(record);
  EXPECT_EQ(rig.metrics.totals().faults[static_cast<std::size_t>(core::Fault::kEmergencyStop)], 2u);
  EXPECT_EQ(rig.metrics.totals().faults[static_cast<std::size_t>(core::Fault::kLoopLate)], 0u);
}

TEST(TickMetrics, ALimiterCountsEveryTickItActsIn) {
  MeteredRig rig;
  core::TickRecord record;
  record.effort.limiters.set(core::Limiter::kSlew);
  for (int i = 0; i < 10; ++i) rig.metrics.on_record(record);
  EXPECT_EQ(rig.metrics.totals().limited[static_cast<std::size_t>(core::Limiter::kSlew)], 10u);
  EXPECT_EQ(rig.metrics.totals().limited[static_cast<std::size_t>(core::Limiter::kSaturation)], 0u);
}

TEST(TickMetrics, AChangeOfCarrierCountsUnderOneLeaseOnly) {
  Carrier carrier = Carrier::kGrpc;
  TickMetrics metrics([&] { return carrier; });
  core::TickRecord record;
  record.beat.dt = std::chrono::milliseconds(1);
  record.input.command.lease_held = true;
  record.input.command.lease_epoch = 1;
  for (int i = 0; i < 3; ++i) metrics.on_record(record);
  carrier = Carrier::kUdp;
  for (int i = 0; i < 5; ++i) metrics.on_record(record);
  EXPECT_EQ(metrics.totals().carrier_changes, 1u);
  record.input.command.lease_epoch = 2;
  carrier = Carrier::kGrpc;
  metrics.on_record(record);
  EXPECT_EQ(metrics.totals().carrier_changes, 1u);
  EXPECT_NEAR(metrics.totals().carrier_s[1], 0.004, 1e-12);
  EXPECT_NEAR(metrics.totals().carrier_s[2], 0.005, 1e-12);
}

TEST(Ingress, TotalsOutliveALease) {
  DeviceRig rig;
  rig.control("s1");
  rig.publish(0.0);
  rig.sessions->close("s1");
  rig.tick(300);
  rig.control("s2", "bob");
  rig.publish(0.0);
  EXPECT_EQ(rig.sessions->ingress().counters().accepted, 1u);
  EXPECT_EQ(rig.sessions->ingress().totals().accepted, 2u);
}

}  // namespace
}  // namespace haptic::server
