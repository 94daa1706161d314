/// Every scenario of tests/relay/README.md#rows on virtual time, through the shipped wire, ingress,
/// sessions and pipeline.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <tuple>

#include "tests/relay/matrix_table.hpp"
#include "tests/relay/virtual_world.hpp"

namespace haptic::test {
namespace {

constexpr LinkTime kSamplePeriod = VirtualWorld::kSamplePeriod;

std::string milliseconds(core::Duration time) {
  return std::to_string(time / 1ms) + " ms";
}

/// proto/README.md#staleness-and-gain, written out again: the code under test must not judge
/// itself.
struct Written {
  static constexpr core::Duration kFresh = 5 * kSamplePeriod / 2, kHold = 100ms, kFade = 180ms;
  static core::Staleness level(core::Duration age) {
    if (age < kFresh) return core::Staleness::kFresh;
    if (age < kHold) return core::Staleness::kHold;
    return age < kFade ? core::Staleness::kFade : core::Staleness::kLost;
  }
  static double ladder(core::Duration age) {
    return std::clamp(core::seconds(kFade - age) / core::seconds(kFade - kHold), 0.0, 1.0);
  }
};

/// Levels and gain are what the age allows, and the age is what it was: never younger than the
/// arrival, and, but for back-log, never older than the sample truly is.
void check_age(const VirtualWorld& world, const core::TickRecord& now) {
  if (now.proxy.mode == core::ProxyMode::kNone) return;
  ASSERT_EQ(now.proxy.level, Written::level(now.proxy.age));
  ASSERT_LE(now.life.gain, Written::ladder(now.proxy.age) + 1e-12);
  const VirtualWorld::Way& way = world.ways.at(now.proxy.seq);
  ASSERT_GE(now.proxy.age, now.input.now - way.accepted);
  if (!way.backlog) {
    constexpr core::Duration kClockError = 500us;
    ASSERT_LE(now.proxy.age, now.input.now - way.published + kClockError);
  }
}

/// Held proxies, or contacts.
class VirtualMatrix : public testing::TestWithParam<std::tuple<Scenario, bool>> {};

TEST_P(VirtualMatrix, TheContractHoldsAtEveryTick) {
  const auto& [scenario, contacts] = GetParam();
  MatrixRow row(
      (contacts ? "virtual-contacts/" : "virtual/") + scenario.name,
      "levels and gain by age, and the age is true; seq never back; force moves by at most "
      "the slew limit; energy within the tank; no elastic force 200 ms after the last "
      "sample; no fault");
  VirtualWorld world(scenario);
  world.contacts = contacts;
  core::TickRecord before = world.rig.newest();
  int engages = 0;
  double steepest = 0.0, energy = 0.0, most = 0.0, strongest = 0.0;
  core::Duration oldest{0};
  while (world.time() < scenario.duration) {
    world.step();
    const core::TickRecord now = world.rig.newest();
    SCOPED_TRACE(world.time().count());
    ASSERT_GE(now.proxy.seq, now.proxy.mode == core::ProxyMode::kNone ? 0 : before.proxy.seq);
    // Neither the envelope of 10 N nor a fault has anything to take away here.
    const double step = std::abs(now.effort.tau_a[0] - before.effort.tau_a[0]);
    ASSERT_LE(step, VirtualWorld::kSlewPerTick + 1e-9);
    steepest = std::max(steepest, step);
    ASSERT_NO_FATAL_FAILURE(check_age(world, now));
    if (now.input.now - world.last_accepted > 200ms) {
      ASSERT_EQ(now.effort.tau_elastic[0], 0.0);
    }
    ASSERT_EQ(now.faults().bits(), 0U);
    // Work of the command held over the tick; what the device's own damping takes is not given.
    const double move = now.sensed.q[0] - before.sensed.q[0];
    energy += before.effort.tau_a[0] * move - VirtualWorld::kDeviceDamping * move * move / 1e-3;
    most = std::max(most, energy);
    engages +=
        now.life.state == core::LifecycleState::kEngaging && before.life.state != now.life.state
            ? 1
            : 0;
    ASSERT_LE(energy, VirtualWorld::kTank * engages + 1e-9);
    if (engages > 0) oldest = std::max(oldest, now.proxy.age);
    strongest = std::max(strongest, std::abs(now.effort.tau_elastic[0]));
    before = now;
  }
  EXPECT_GT(world.accepted, 0U);
  EXPECT_GT(engages, 0);
  EXPECT_GT(strongest, 0.1);
  row.got("oldest proxy " + milliseconds(oldest));
  row.got("steepest " + std::to_string(steepest) + " N per ms");
  row.got("energy out " + std::to_string(1e3 * most) + " mJ, " + std::to_string(engages) +
          " engages");
  row.got(std::to_string(world.fallbacks) + " fallbacks");
}

INSTANTIATE_TEST_SUITE_P(Shipped, VirtualMatrix,
                         testing::Combine(testing::ValuesIn(shipped_scenarios()), testing::Bool()),
                         [](const auto& test) {
                           return std::get<0>(test.param).name +
                                  (std::get<1>(test.param) ? "_contacts" : "");
                         });

/// Runs to `until`; the largest age of the proxy in use from `from` on.
core::Duration oldest_proxy(VirtualWorld& world, LinkTime from, LinkTime until) {
  core::Duration oldest{0};
  while (world.time() < until) {
    world.step();
    if (world.time() > from) oldest = std::max(oldest, world.rig.newest().proxy.age);
  }
  return oldest;
}

/// A failing path is doubted before it is given up; while in doubt, samples go both ways.
TEST(VirtualMatrixRow, BlockedUdpCostsAHold) {
  for (const LinkTime period : {5ms, 10ms, 20ms, 33ms}) {
    for (const LinkTime phase : {0ms, 3ms, 7ms}) {
      SCOPED_TRACE(milliseconds(period) + " " + milliseconds(phase));
      Scenario scenario = shipped_scenario("udp_blocked");
      for (WayRules* way : {&scenario.up, &scenario.down}) way->partitions.at(0).from += phase;
      VirtualWorld world(scenario, period);
      EXPECT_LE(oldest_proxy(world, 1s, 12s), world.lease.staleness.hold_end);
      EXPECT_EQ(world.fallbacks, 1);
      EXPECT_EQ(world.rig.state(), core::LifecycleState::kEngaged);
      EXPECT_EQ(world.rig.sessions->status().carrier, server::Carrier::kUdp);
    }
  }
}

/// With a round trip of 60 ms, silence takes three of them, 180 ms: force fades but is not lost.
TEST(VirtualMatrixRow, DistantBlockedUdpStaysEngaged) {
  for (const LinkTime period : {10ms, 33ms}) {
    Scenario scenario = shipped_scenario("udp_blocked");
    scenario.up.delay = scenario.down.delay = 30ms;
    VirtualWorld world(scenario, period);
    EXPECT_LT(oldest_proxy(world, 1s, 12s), world.lease.staleness.fade_end) << milliseconds(period);
    EXPECT_EQ(world.fallbacks, 1);
    EXPECT_EQ(world.rig.state(), core::LifecycleState::kEngaged);
  }
}

TEST(VirtualMatrixRow, LossOf10PercentStaysEngaged) {
  for (const char* name : {"loss_01", "loss_05", "loss_10"}) {
    VirtualWorld world(shipped_scenario(name));
    // Five in a row are one in 100 000 at 10 %.
    EXPECT_LE(oldest_proxy(world, 2s, 10s), 5 * kSamplePeriod + 1ms) << name;
    EXPECT_EQ(world.rig.state(), core::LifecycleState::kEngaged) << name;
    EXPECT_EQ(world.rig.sessions->status().carrier, server::Carrier::kUdp) << name;
  }
}

}  // namespace
}  // namespace haptic::test
