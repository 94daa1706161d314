#include "server/owner/telemetry/tick_metrics.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/server/support/device_rig.hpp"

namespace haptic::server {
namespace {

using test::DeviceRig;

struct MeteredRig : DeviceRig {
  MeteredRig() { owner->count_into(metrics); }
  [[nodiscard]] TickTotals totals() const { return metrics->totals(0); }
  std::shared_ptr<TickMetrics> metrics{std::make_shared<TickMetrics>(1)};
};

std::uint64_t all(const HistogramView& h) {
  return std::accumulate(h.counts.begin(), h.counts.end(), std::uint64_t{0});
}

TEST(TickMetrics, ResidenceIsTimePerLevel) {
  MeteredRig rig;
  rig.tick(50);  // nobody controls: no level is counted
  EXPECT_EQ(rig.totals().level_s, (std::array<double, 4>{}));
  rig.control();
  const double before = rig.totals().level_s[3];  // LOST until the first sample
  for (int i = 0; i < 100; ++i) {
    rig.publish(0.0);
    rig.tick();
  }
  rig.tick(300);  // silence: 5 ms fresh at 1 kHz, hold to 100 ms, fade to 180 ms, lost after
  const TickTotals totals = rig.totals();
  const double tick = 1e-3;
  // A sample is published between ticks and is 1 ms old at the next: ages 1..5 ms, half-open.
  EXPECT_NEAR(totals.level_s[0], 0.104, 1.5 * tick);
  EXPECT_NEAR(totals.level_s[1], 0.095, 1.5 * tick);
  EXPECT_NEAR(totals.level_s[2], 0.080, 1.5 * tick);
  EXPECT_NEAR(totals.level_s[3] - before, 0.121, 2.5 * tick);
}

TEST(TickMetrics, CountsTicksOnceAgesWithProxy) {
  MeteredRig rig;
  rig.tick(20);
  EXPECT_EQ(all(rig.totals().age), 0u);
  EXPECT_EQ(all(rig.totals().lateness), 20u);
  EXPECT_EQ(all(rig.totals().period), 19u);  // between two ticks
  EXPECT_NEAR(rig.totals().period.sum(), 0.019, 1e-9);
  rig.control();
  const std::uint64_t ages = all(rig.totals().age);
  rig.publish(0.0);
  rig.tick(7);
  EXPECT_EQ(all(rig.totals().age) - ages, 7u);
}

TEST(TickMetrics, AgeIsTheNewestSamples) {
  TickMetrics metrics(1);
  core::TickRecord record;
  metrics.count(0, {record});
  EXPECT_EQ(all(metrics.totals(0).sample_age), 0u) << "no sample came so far";
  record.input.device.sample.seq = 1;
  for (const int age_us : {1600, 2600}) {
    record.input.now = record.input.device.sample.time + std::chrono::microseconds(age_us);
    metrics.count(0, {record});
  }
  const auto age = metrics.totals(0).sample_age;
  EXPECT_EQ(all(age), 2u);
  EXPECT_NEAR(age.sum(), 0.0016 + 0.0026, 1e-9);
}

TEST(TickMetrics, FaultCountsOnceWhenItLatches) {
  MeteredRig rig;
  rig.tick(5);
  core::TickRecord record;
  record.life.faults.set(core::Fault::kEmergencyStop);
  for (int i = 0; i < 10; ++i) rig.metrics->count(0, {record});
  record.life.faults = {};
  rig.metrics->count(0, {record});
  record.life.faults.set(core::Fault::kEmergencyStop);
  rig.metrics->count(0, {record});
  EXPECT_EQ(rig.totals().faults[static_cast<std::size_t>(core::Fault::kEmergencyStop)], 2u);
  EXPECT_EQ(rig.totals().faults[static_cast<std::size_t>(core::Fault::kLoopLate)], 0u);
}

TEST(TickMetrics, LimiterCountsEveryActiveTick) {
  MeteredRig rig;
  core::TickRecord record;
  record.effort.limiters.set(core::Limiter::kSlew);
  for (int i = 0; i < 10; ++i) rig.metrics->count(0, {record});
  EXPECT_EQ(rig.totals().limited[static_cast<std::size_t>(core::Limiter::kSlew)], 10u);
  EXPECT_EQ(rig.totals().limited[static_cast<std::size_t>(core::Limiter::kSaturation)], 0u);
}

TEST(TickMetrics, CarrierChangeCountsWithinALease) {
  TickMetrics metrics(1);
  core::TickRecord record;
  record.beat.dt = std::chrono::milliseconds(1);
  record.input.command.lease_held = true;
  record.input.command.tenure = 1;
  for (int i = 0; i < 3; ++i) metrics.count(0, {record, Carrier::kGrpc});
  for (int i = 0; i < 5; ++i) metrics.count(0, {record, Carrier::kUdp});
  EXPECT_EQ(metrics.totals(0).carrier_changes, 1u);
  record.input.command.tenure = 2;
  metrics.count(0, {record, Carrier::kGrpc});
  EXPECT_EQ(metrics.totals(0).carrier_changes, 1u);
  EXPECT_NEAR(metrics.totals(0).carrier_s[1], 0.004, 1e-12);
  EXPECT_NEAR(metrics.totals(0).carrier_s[2], 0.005, 1e-12);
}

TEST(Ingress, TotalsOutliveALease) {
  DeviceRig rig;
  rig.control("s1");
  rig.publish(0.0);
  rig.sessions->close("s1");
  rig.tick(300);
  rig.control("s2", "bob");
  rig.publish(0.0);
  EXPECT_EQ(rig.sessions->status().samples[IngressVerdict::kAccepted], 2u);
}

}  // namespace
}  // namespace haptic::server
