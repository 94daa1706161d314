#include "server/owner/loop/device_unit.hpp"

#include <gtest/gtest.h>

#include "tests/server/support/device_rig.hpp"
#include "tests/support/identical.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::core::TimePoint;

TEST(DeviceUnit, RehearsesWithoutATrace) {
  haptic::test::DeviceRig rehearsed, plain;
  rehearsed.unit->rehearse();
  for (int tick = 0; tick < 50; ++tick) {
    rehearsed.tick();
    plain.tick();
    ASSERT_TRUE(haptic::core::identical(rehearsed.newest(), plain.newest()));
  }
}

/// Two under one thread, once in peace and once while the other one is lost.
TEST(DeviceUnit, AnothersFaultChangesNoBit) {
  haptic::test::DeviceRig in_peace, calm, beside_a_fault, lost;
  const auto all = {&in_peace, &calm, &beside_a_fault, &lost};
  for (haptic::test::DeviceRig* rig : all) {
    rig->control();
    rig->press();
  }
  lost.device->lost = true;
  for (int tick = 0; tick < 100; ++tick) {
    for (haptic::test::DeviceRig* rig : all) rig->stream(1, 0.01);
    ASSERT_TRUE(haptic::core::identical(in_peace.newest(), beside_a_fault.newest())) << tick;
  }
  EXPECT_GT(beside_a_fault.device->force, 0.5);
  EXPECT_EQ(calm.state(), haptic::core::LifecycleState::kEngaged);
  EXPECT_EQ(lost.state(), haptic::core::LifecycleState::kFault);
}

TEST(DeviceUnit, TickGetsEachMailboxsNewest) {
  haptic::test::DeviceRig rig;
  haptic::core::ProxySnapshot proxy{.mode = haptic::core::ProxyMode::kFree, .tenure = 7, .seq = 1};
  rig.unit->proxies.publish(proxy);
  proxy.seq = 2;
  rig.unit->proxies.publish(proxy);
  haptic::core::CommandSnapshot command{.tenure = 7, .lease_held = true};
  rig.unit->commands.publish(command);
  rig.unit->tick(TimePoint(1h), 1ms, {300us, 4});
  const auto& input = rig.unit->records.front()->input;
  EXPECT_EQ(rig.unit->records.front()->proxy.seq, 2u);
  EXPECT_EQ(input.command.tenure, 7u);
  EXPECT_EQ(input.now, TimePoint(1h));
  EXPECT_EQ(input.loop.lateness, 300us);
  EXPECT_EQ(input.loop.skipped, 4u);
  EXPECT_TRUE(input.device.fresh);
}

TEST(DeviceUnit, SlowDrainCountsLostRecords) {
  haptic::test::DeviceRig rig;
  const int ticks = static_cast<int>(rig.unit->records.capacity()) + 10;
  for (int i = 0; i < ticks; ++i) rig.unit->tick(TimePoint(1h) + i * 1ms, 1ms, {});
  EXPECT_EQ(rig.unit->records.dropped(), 10u);
  for (std::uint64_t tick = 1; tick <= rig.unit->records.capacity(); ++tick) {
    ASSERT_NE(rig.unit->records.front(), nullptr);
    ASSERT_EQ(rig.unit->records.front()->beat.tick, tick) << "the oldest are kept";
    rig.unit->records.pop();
  }
  EXPECT_EQ(rig.unit->records.front(), nullptr);
  rig.unit->tick(TimePoint(1h) + ticks * 1ms, 1ms, {});
  ASSERT_NE(rig.unit->records.front(), nullptr);
  EXPECT_EQ(rig.unit->records.front()->beat.tick, static_cast<std::uint64_t>(ticks + 1));
}

}  // namespace
