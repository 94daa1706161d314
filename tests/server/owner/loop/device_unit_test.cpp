#include "server/owner/loop/device_unit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "hw/board/board_device.hpp"
#include "hw/simulated/finger.hpp"
#include "server/owner/scene/scene.hpp"
#include "tests/server/support/device_rig.hpp"
#include "tests/support/allocation_guard.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::core::LifecycleState;
using haptic::core::TimePoint;
using haptic::server::DeviceScene;
using haptic::server::DeviceUnit;
using haptic::test::AllocationGuard;

std::vector<std::filesystem::path> scenes() {
  std::vector<std::filesystem::path> files;
  const std::filesystem::path folder = std::string(HAPTIC_SOURCE_DIR) + "/server/scenes";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".textproto") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::unique_ptr<DeviceUnit> make_unit(const DeviceScene& scene) {
  // A board is hardware: its scene's pipeline then runs on the simulation of what it moves.
  const haptic::hw::SimulatedFingerConfig simulated;
  const haptic::hw::DeviceConfig& source = scene.source->is_hardware() ? simulated : *scene.source;
  auto device = source.open(scene.pipeline.kinematics, {});
  auto config = haptic::server::pipeline_config(scene, device->info().limits);
  return std::make_unique<DeviceUnit>(scene.name, std::move(device), std::move(config));
}

/// A client that takes the lease, sets its proxy free, holds it at the probe, engages, presses,
/// sets it free, and lets go.
class ScriptedClient {
 public:
  void step(DeviceUnit& unit, int tick, TimePoint now) {
    if (const auto* record = unit.records.front()) {
      newest_ = *record;
      unit.records.pop();
    }
    seen.insert(newest_.life.state);
    most_force =
        std::max(most_force, newest_.effort.tau_a.size() > 0 ? newest_.effort.tau_a.norm() : 0.0);
    command_.lease_held = tick >= 5;
    command_.tenure = tick >= 5 ? 1 : 0;
    command_.engage_id = tick >= 300 ? 1 : 0;
    command_.release_id = tick >= 1500 ? 1 : 0;
    command_.stop_id = tick >= 1800 ? 1 : 0;
    unit.commands.publish(command_);
    if (unit.config().tracker) {
      pose_.staleness = unit.config().tracker->staleness;
      ++pose_.seq;
      pose_.born = now;
      unit.poses.publish(pose_);
    }
    if (tick % 16 != 0 || newest_.anchor.x_probe.size() == 0) return;
    const bool free = tick < 50 || (tick > 1000 && tick < 1200);
    proxy_.mode = free ? haptic::core::ProxyMode::kFree : haptic::core::ProxyMode::kHeld;
    proxy_.tenure = 1;
    ++proxy_.seq;
    proxy_.born = now;
    proxy_.x = newest_.anchor.x_probe;
    if (tick > 600) proxy_.x.array() -= 0.01;
    if (proxy_.gapless_samples++ == 0) proxy_.gapless_since = now;
    unit.proxies.publish(proxy_);
  }

  std::set<LifecycleState> seen{};
  double most_force{0.0};

 private:
  haptic::core::TickRecord newest_{};
  haptic::core::CommandSnapshot command_{};
  haptic::core::ProxySnapshot proxy_{};
  haptic::core::TrackerSnapshot pose_{};
};

class EveryScene : public testing::TestWithParam<std::filesystem::path> {};

TEST_P(EveryScene, TicksWithoutAllocation) {
  const haptic::server::Scene scene = haptic::server::load_scene(GetParam());
  for (const DeviceScene& device : scene.devices) {
    const auto unit = make_unit(device);
    ScriptedClient client;
    TimePoint now(1h);
    std::uint64_t allocations = 0;
    std::uint64_t releases = 0;
    for (int tick = 0; tick < 2000; ++tick) {
      now += 1ms;
      const AllocationGuard guard;
      unit->tick(now, 1ms, {});
      allocations += guard.allocations();
      releases += guard.releases();
      client.step(*unit, tick, now);
    }
    EXPECT_EQ(allocations, 0u) << device.name;
    EXPECT_EQ(releases, 0u) << device.name;
    // The script really went through force and its end.
    EXPECT_TRUE(client.seen.contains(LifecycleState::kEngaged)) << device.name;
    EXPECT_TRUE(client.seen.contains(LifecycleState::kReleasing)) << device.name;
    EXPECT_TRUE(client.seen.contains(LifecycleState::kFault)) << device.name;
    EXPECT_GT(client.most_force, 0.0) << device.name;
  }
}

TEST_P(EveryScene, RehearsesWithoutATrace) {
  const haptic::server::Scene scene = haptic::server::load_scene(GetParam());
  const DeviceScene& device = scene.devices.front();
  const auto rehearsed = make_unit(device);
  const auto plain = make_unit(device);
  rehearsed->rehearse();
  TimePoint now(1h);
  for (int tick = 0; tick < 50; ++tick) {
    now += 1ms;
    rehearsed->tick(now, 1ms, {});
    plain->tick(now, 1ms, {});
    ASSERT_TRUE(haptic::core::identical(*rehearsed->records.front(), *plain->records.front()));
    rehearsed->records.pop();
    plain->records.pop();
  }
}

INSTANTIATE_TEST_SUITE_P(OfTheServer, EveryScene, testing::ValuesIn(scenes()),
                         [](const auto& file) { return file.param.stem().string(); });

TEST(DeviceUnit, TickGetsEachMailboxsNewest) {
  haptic::test::DeviceRig rig;
  haptic::core::ProxySnapshot proxy{.seq = 1};
  rig.unit->proxies.publish(proxy);
  proxy.seq = 2;
  rig.unit->proxies.publish(proxy);
  haptic::core::CommandSnapshot command{.tenure = 7};
  rig.unit->commands.publish(command);
  rig.unit->tick(TimePoint(1h), 1ms, {300us, 4});
  const auto& input = rig.unit->records.front()->input;
  EXPECT_EQ(input.proxy.seq, 2u);
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
