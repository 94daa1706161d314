// Three boards under one loop, in virtual time: each on its own, whatever happens to another.
#include <gtest/gtest.h>

#include <array>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "server/owner/loop/device_unit.hpp"
#include "tests/support/virtual_board.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::core::Fault;
using haptic::core::LifecycleState;
using haptic::core::TickRecord;
using haptic::core::TimePoint;
using haptic::core::VecA;
using haptic::hw::emulator::EmulatorConfig;
using haptic::hw::emulator::FaultKind;
using haptic::hw::emulator::VirtualBoard;
using haptic::server::DeviceUnit;

constexpr int kBoards = 3;

/// One board with its unit and a client of its own that presses and engages again after a fault.
class Served {
 public:
  explicit Served(std::uint64_t seed) {
    const std::shared_ptr<const haptic::core::Kinematics> finger =
        haptic::core::make_finger_exoskeleton({});
    EmulatorConfig board{.seed = seed, .serial = "FINGER-" + std::to_string(seed)};
    haptic::hw::BoardConfig wanted;
    wanted.max_effort = VecA::Constant(1, 40.0);
    auto device = std::make_unique<VirtualBoard>(
        board, haptic::hw::Intent(Eigen::Vector2d::Zero(), Eigen::Vector2d(0.8, 0.6)), wanted,
        finger);
    board_ = device.get();
    haptic::core::PipelineConfig config{.kinematics = finger, .device = device->info().limits};
    config.scene.direction_guard = true;
    config.scene.stiffness = VecA::Constant(1, 500.0);
    config.scene.damping = VecA::Constant(1, 0.5);
    config.scene.force_limit = VecA::Constant(1, 20.0);
    config.scene.slew_limit = VecA::Constant(1, 2000.0);
    config.scene.engage_window = VecA::Constant(1, 20.0);
    unit = std::make_unique<DeviceUnit>(board.serial, std::move(device), std::move(config));
    command_.tenure = 1;
    command_.lease_held = true;
    proxy_.tenure = 1;
    proxy_.x = haptic::core::VecX::Zero(2);
  }

  void tick(TimePoint now) {
    if (newest.anchor.x_probe.size() == 2) {
      proxy_.x = newest.anchor.x_probe;
      proxy_.x[0] = std::min(proxy_.x[0], 0.3);
    }
    proxy_.born = now;
    using haptic::core::ProxyMode;
    proxy_.mode = ++proxy_.seq == 1 ? ProxyMode::kFree : ProxyMode::kHeld;  // from outside
    if (proxy_.seq == 1) proxy_.gapless_since = now;
    ++proxy_.gapless_samples;
    if (newest.life.state == LifecycleState::kArmed) ++command_.engage_id;
    unit->proxies.publish(proxy_);
    unit->commands.publish(command_);
    unit->tick(now, 1ms, {});
    const TickRecord* record = unit->records.front();
    ASSERT_NE(record, nullptr);
    newest = *record;
    unit->records.pop();
  }
  void clear() {
    ++command_.clear_id;
    command_.clear = newest.faults();
  }
  void unplug(double length) {
    board_->board().add_fault(
        {FaultKind::kUnplug, static_cast<double>(board_->board().now_us()) * 1e-6, length, 0.0});
  }

  std::unique_ptr<DeviceUnit> unit;
  TickRecord newest{};

 private:
  VirtualBoard* board_{nullptr};
  haptic::core::ProxySnapshot proxy_{};
  haptic::core::CommandSnapshot command_{};
};

struct ThreeBoards {
  Served one{1}, two{2}, three{3};
  std::array<Served*, kBoards> all{&one, &two, &three};
  TimePoint now{1h};
  void run_ms(int ms) {
    for (int i = 0; i < ms; ++i) {
      now += 1ms;
      for (Served* board : all) board->tick(now);  // one thread for all, in order
    }
  }
};

TEST(SeveralDevices, ThreeBoardsPressAtOnce) {
  ThreeBoards boards;
  boards.run_ms(1500);
  for (const Served* board : boards.all) {
    EXPECT_EQ(board->newest.life.state, LifecycleState::kEngaged);
    EXPECT_GT(std::abs(board->newest.effort.tau_a[0]), 0.5);
  }
}

TEST(SeveralDevices, UnpluggingOneChangesNoOther) {
  ThreeBoards calm, disturbed;
  calm.run_ms(1200);
  disturbed.run_ms(1200);
  disturbed.two.unplug(0.4);
  bool faulted = false;
  for (int i = 0; i < 800; ++i) {
    calm.run_ms(1);
    disturbed.run_ms(1);
    ASSERT_TRUE(identical(calm.one.newest, disturbed.one.newest)) << i;
    ASSERT_TRUE(identical(calm.three.newest, disturbed.three.newest)) << i;
    faulted = faulted || disturbed.two.newest.life.state == LifecycleState::kFault;
  }
  EXPECT_TRUE(faulted);
  EXPECT_EQ(calm.two.newest.life.state, LifecycleState::kEngaged);
  EXPECT_EQ(disturbed.one.newest.life.state, LifecycleState::kEngaged);
}

TEST(SeveralDevices, FaultsAreClearedOneByOne) {
  ThreeBoards boards;
  boards.run_ms(1200);
  boards.one.unplug(0.2);
  boards.three.unplug(0.2);
  boards.run_ms(700);
  EXPECT_EQ(boards.one.newest.life.state, LifecycleState::kFault);
  EXPECT_EQ(boards.two.newest.life.state, LifecycleState::kEngaged);
  EXPECT_EQ(boards.three.newest.life.state, LifecycleState::kFault);
  boards.one.clear();
  boards.run_ms(700);
  EXPECT_EQ(boards.one.newest.life.state, LifecycleState::kEngaged);
  EXPECT_TRUE(boards.three.newest.faults().has(Fault::kDeviceLost)) << "nobody cleared that one";
}

}  // namespace
