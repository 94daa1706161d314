/// The rows of tests/relay/README.md#rows about clients that go wrong and a server that ends, on
/// virtual time.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "tests/relay/matrix_table.hpp"
#include "tests/relay/virtual_world.hpp"

namespace haptic::test {
namespace {

constexpr LinkTime kTroubleAt = 2s;

/// Steps to `until`; in every tick the elastic force is under what the age of the newest accepted
/// sample allows (proto/README.md#staleness-and-gain: full to 100 ms, linear to 0 at 180 ms) and
/// moves by the slew limit at most.
void watch(VirtualWorld& world, LinkTime until) {
  while (world.time() < until) {
    const double before = world.force();
    world.step();
    const core::TickRecord now = world.rig.newest();
    const double age = std::chrono::duration<double>(now.input.now - world.last_accepted).count();
    const double ladder = std::clamp((0.180 - age) / 0.080, 0.0, 1.0);
    ASSERT_LE(std::abs(now.effort.tau_elastic[0]), 10.0 * ladder + 1e-9) << world.time().count();
    ASSERT_LE(std::abs(now.effort.tau_a[0] - before), VirtualWorld::kSlewPerTick + 1e-9);
    ASSERT_EQ(now.faults().bits(), 0U);
  }
}

/// Refused at the door; the last good sample ages and fades.
TEST(VirtualClient, RefusesBadNumbersAndFades) {
  for (const auto& [name, bad, verdict] :
       {std::tuple("virtual/nan", std::numeric_limits<double>::quiet_NaN(),
                   server::IngressVerdict::kNotFinite),
        {"virtual/huge_values", 1e300, server::IngressVerdict::kOutOfBounds}}) {
    MatrixRow row(name, "refused and counted; force by the ladder; back by a ramp");
    SCOPED_TRACE(name);
    VirtualWorld world(shipped_scenario("delay_10ms"));
    watch(world, kTroubleAt);
    ASSERT_GT(world.force(), 0.5);
    const auto good = std::exchange(world.proxy, [bad = bad](LinkTime) { return bad; });
    watch(world, kTroubleAt + 500ms);
    EXPECT_EQ(world.rig.newest().effort.tau_elastic[0], 0.0);
    EXPECT_GE(world.rig.sessions->status().samples[verdict], 48U);  // 500 ms at 100 Hz, 10 ms late
    world.proxy = good;
    watch(world, kTroubleAt + 2s);
    EXPECT_EQ(world.rig.state(), core::LifecycleState::kEngaged);
    row.got("as expected");
  }
}

TEST(VirtualClient, KilledClientLosesForceAndLease) {
  MatrixRow row("virtual/client_killed",
                "no elastic force after 200 ms; IDLE and command zero when the lease (2 s) ended");
  VirtualWorld world(shipped_scenario("delay_10ms"));
  watch(world, kTroubleAt);
  world.alive = false;
  watch(world, kTroubleAt + 2300ms);
  EXPECT_EQ(world.rig.state(), core::LifecycleState::kIdle);
  EXPECT_EQ(world.force(), 0.0);
  row.got("IDLE, 0 N");
}

TEST(VirtualClient, PausedClientLosesForceAndRamps) {
  MatrixRow row("virtual/client_paused_300ms", "ladder to zero, LOST, back by Engage and a ramp");
  VirtualWorld world(shipped_scenario("delay_10ms"));
  watch(world, kTroubleAt);
  world.publishing = false;
  watch(world, kTroubleAt + 300ms);
  EXPECT_EQ(world.rig.state(), core::LifecycleState::kArmed);
  EXPECT_EQ(world.rig.newest().effort.tau_elastic[0], 0.0);
  world.publishing = true;
  watch(world, kTroubleAt + 1500ms);
  EXPECT_EQ(world.rig.state(), core::LifecycleState::kEngaged);
  row.got("ARMED at 300 ms, ENGAGED 1.2 s later");
}

TEST(VirtualClient, SigtermFadesTheForceOut) {
  MatrixRow row("virtual/sigterm_under_load", "RELEASING, then CLOSING with command zero");
  VirtualWorld world(shipped_scenario("delay_10ms"));
  watch(world, kTroubleAt);
  world.rig.owner->begin_closing();
  watch(world, kTroubleAt + 40ms);
  EXPECT_EQ(world.rig.state(), core::LifecycleState::kReleasing);
  watch(world, kTroubleAt + 200ms);
  EXPECT_EQ(world.rig.state(), core::LifecycleState::kClosing);
  EXPECT_EQ(world.force(), 0.0);
  row.got("CLOSING, 0 N");
}

}  // namespace
}  // namespace haptic::test
