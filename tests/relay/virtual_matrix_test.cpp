/// Every scenario of WIRE 6 on virtual time, through the shipped wire, ingress, sessions and
/// pipeline.

#include <gtest/gtest.h>

#include "tests/relay/matrix_table.hpp"
#include "tests/relay/virtual_world.hpp"

namespace haptic::test {
namespace {

constexpr LinkTime kSamplePeriod = VirtualWorld::kSamplePeriod;

std::string milliseconds(core::Duration time) {
  return std::to_string(time / 1ms) + " ms";
}

class VirtualMatrix : public testing::TestWithParam<Scenario> {};

TEST_P(VirtualMatrix, TheContractHoldsAtEveryTick) {
  MatrixRow row("virtual/" + GetParam().name,
                "levels and gain by age; seq never back; force rises by at most the slew limit; "
                "no elastic force 200 ms after the last sample; no fault");
  VirtualWorld world(GetParam());
  core::TickRecord before = world.rig.newest();
  bool engaged = false;
  double steepest = 0.0;
  core::Duration oldest{0};
  while (world.time() < GetParam().duration) {
    world.step();
    const core::TickRecord now = world.rig.newest();
    const auto at = world.time();
    ASSERT_GE(now.proxy_seq, now.proxy_mode == core::ProxyMode::kNone ? 0 : before.proxy_seq)
        << at.count();
    // The force moves no faster than the slew limit, but where it is taken away.
    const double step = now.tau_a[0] - before.tau_a[0];
    if (std::abs(now.tau_a[0]) > std::abs(before.tau_a[0])) {
      ASSERT_LE(std::abs(step), VirtualWorld::kSlewPerTick + 1e-9) << at.count();
      steepest = std::max(steepest, std::abs(step));
    }
    // The levels at their ages, and what each allows.
    if (now.proxy_mode != core::ProxyMode::kNone) {
      ASSERT_EQ(now.staleness, core::staleness(now.proxy_age, {}, world.lease.staleness));
      ASSERT_LE(now.gain, core::ladder(now.proxy_age, world.lease.staleness) + 1e-12);
      if (engaged) oldest = std::max(oldest, now.proxy_age);
    }
    if (now.input.now - world.last_accepted > 200ms) {
      ASSERT_EQ(now.tau_elastic[0], 0.0) << at.count();
    }
    ASSERT_EQ(now.faults.bits(), 0U);
    engaged = engaged || now.state == core::DeviceState::kEngaged;
    before = now;
  }
  EXPECT_GT(world.accepted, 0U);
  EXPECT_TRUE(engaged);
  row.got("oldest proxy " + milliseconds(oldest));
  row.got("steepest rise " + std::to_string(steepest) + " N per ms");
  row.got(std::to_string(world.fallbacks) + " fallbacks");
}

INSTANTIATE_TEST_SUITE_P(Shipped, VirtualMatrix, testing::ValuesIn(shipped_scenarios()),
                         [](const auto& test) { return test.param.name; });

/// Runs to `until`; the largest age of the proxy in use from `from` on.
core::Duration oldest_proxy(VirtualWorld& world, LinkTime from, LinkTime until) {
  core::Duration oldest{0};
  while (world.time() < until) {
    world.step();
    if (world.time() > from) oldest = std::max(oldest, world.rig.newest().proxy_age);
  }
  return oldest;
}

TEST(VirtualMatrixRow, BlockedUdpCostsNoMoreThanAHold) {
  VirtualWorld world(shipped_scenario("udp_blocked"));
  EXPECT_LT(oldest_proxy(world, 1s, 12s), world.lease.staleness.fade_end);
  EXPECT_EQ(world.fallbacks, 1);
  EXPECT_EQ(world.rig.state(), core::DeviceState::kEngaged);
  EXPECT_EQ(world.rig.sessions->ingress().carrier(), server::Carrier::kUdp);
}

TEST(VirtualMatrixRow, BlockedTcpIsNotFelt) {
  VirtualWorld world(shipped_scenario("tcp_blocked"));
  EXPECT_LE(oldest_proxy(world, 1s, 12s), kSamplePeriod + 1ms);
  EXPECT_EQ(world.fallbacks, 0);
}

TEST(VirtualMatrixRow, LossUpTo10PercentStaysOnUdpAndFullyEngaged) {
  for (const char* name : {"loss_01", "loss_05", "loss_10"}) {
    VirtualWorld world(shipped_scenario(name));
    // Five in a row are one in 100 000 at 10 %.
    EXPECT_LE(oldest_proxy(world, 2s, 10s), 5 * kSamplePeriod + 1ms) << name;
    EXPECT_EQ(world.rig.state(), core::DeviceState::kEngaged) << name;
    EXPECT_EQ(world.rig.sessions->ingress().carrier(), server::Carrier::kUdp) << name;
  }
}

TEST(VirtualMatrixRow, ADuplicateIsRejectedByTheWindowNotByTheDoor) {
  VirtualWorld world(shipped_scenario("duplicate_100"));
  static_cast<void>(oldest_proxy(world, 0s, 5s));
  EXPECT_GT(world.server.counters().duplicate(), 300U);
  EXPECT_EQ(world.rig.sessions->ingress().counters().old_sequence, 0U);
}

TEST(VirtualMatrixRow, ABackLogIsNotRenderedAsFresh) {
  VirtualWorld world(shipped_scenario("stall_backlog"));
  bool backlog = false;
  while (world.time() < 3s) {
    world.step();
    backlog = backlog || world.rig.sessions->ingress().counters().backlog > 0;
    if (world.time() > 2200ms && world.time() < 2300ms) {
      EXPECT_EQ(world.rig.newest().tau_elastic[0], 0.0);  // 180 ms and more without a sample
    }
  }
  EXPECT_TRUE(backlog);
}

TEST(MatrixTable, ALineIsReadByAnyoneWhoReadsCsv) {
  EXPECT_EQ(csv_line("a/b", "x, \"y\"", "z", false), "a/b,\"x, \"\"y\"\"\",z,FAILED\n");
}

}  // namespace
}  // namespace haptic::test
