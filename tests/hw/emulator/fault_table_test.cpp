// Each fault of the emulated board ends in its documented state (hw/README.md, "The emulator") in
// the promised time: the tick's pipeline on the board's protocol, firmware and rig, in virtual
// time. The moment of each fault is drawn from the seed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hw/random.hpp"
#include "tests/support/pressed_board.hpp"

namespace haptic::hw::emulator {
namespace {

using core::Fault;
using core::LifecycleState;
using test::PressedBoard;

/// A fault of this board that begins now.
void fault(PressedBoard& finger, FaultKind kind, double length, double amount = 0.0) {
  const double now = static_cast<double>(finger.board().now_us()) * 1e-6;
  finger.board().add_fault({kind, now, length, amount});
}

/// When the faults of a seed begin, ms after the pressing began.
int moment(std::uint64_t seed) {
  std::mt19937_64 random(seed * 7919);
  return 50 + static_cast<int>(400.0 * uniform(random));
}

struct PressedCase : ::testing::TestWithParam<std::uint64_t> {
  PressedBoard finger{setup()};
  void SetUp() override { press(finger); }
  /// The finger goes on bending into a wall at its first joint.
  static test::PressedBoardSetup setup() {
    static constexpr double kWall = 0.3;  // rad
    return {.emulator = {.seed = GetParam()}, .proxy = [](const core::VecX& x) {
              return (core::VecX(2) << std::min(x[0], kWall), x[1]).finished();
            }};
  }
  /// Engaged, with force, at the moment of this seed.
  static void press(PressedBoard& finger) {
    finger.run_ms(900 + moment(GetParam()));
    ASSERT_EQ(finger.last().life.state, LifecycleState::kEngaged);
    ASSERT_GT(std::abs(finger.last().effort.tau_a[0]), 0.5);
    ASSERT_TRUE(finger.board().drives());
  }
  /// Ticks until FAULT; the command is zero from the very tick on, and stays.
  static int until_fault(PressedBoard& finger, int at_most_ms) {
    for (int ms = 1; ms <= at_most_ms; ++ms) {
      const core::TickRecord record = finger.tick();
      EXPECT_LE(std::abs(record.effort.tau_a[0]), PressedBoard::kForceLimit + 1e-9);
      if (record.life.state != LifecycleState::kFault) continue;
      EXPECT_EQ(record.effort.tau_a[0], 0.0);
      return ms;
    }
    ADD_FAILURE() << "no fault within " << at_most_ms << " ms";
    return at_most_ms + 1;
  }
  /// The board's drive is off after at most `ms`.
  static void expect_drive_off(PressedBoard& finger, int ms) {
    for (int i = 0; i < ms && finger.board().drives(); ++i) finger.tick();
    EXPECT_FALSE(finger.board().drives());
  }
  /// The cause is gone: cleared, the device comes back to force by way of IDLE.
  static void expect_return(PressedBoard& finger) {
    finger.run_ms(600);
    EXPECT_EQ(finger.last().life.state, LifecycleState::kFault) << "latched until it is cleared";
    finger.clear();
    bool idle = false;
    for (int i = 0; i < 1000 && finger.last().life.state != LifecycleState::kEngaged; ++i) {
      finger.tick();
      idle = idle || finger.last().life.state == LifecycleState::kIdle;
    }
    EXPECT_TRUE(idle);
    EXPECT_EQ(finger.last().life.state, LifecycleState::kEngaged);
  }
};

TEST_P(PressedCase, FewDamagedBytesAreOnlyCounted) {
  test::PressedBoardSetup lossy = setup();
  lossy.emulator.drop = lossy.emulator.corrupt = 1e-4;
  PressedBoard damaged(lossy);
  press(damaged);
  damaged.run_ms(4000);
  EXPECT_EQ(damaged.last().life.state, LifecycleState::kEngaged);
  EXPECT_FALSE(damaged.last().faults().any());
  const board::HostCounters& n = damaged.device().counters();
  const auto here = n.bad_crc + n.malformed + n.lost;
  const auto& there = damaged.board().firmware().counters;
  EXPECT_GT(here, 0u);
  EXPECT_GT(there.bad_crc + there.malformed, 0u);
}

TEST_P(PressedCase, LossyLinkIsASilentDevice) {
  finger.board().set_noise(0.2, 0.2);
  // 10 ms of silence and the tick that sees it, after the last frame that came through by luck.
  until_fault(finger, 400);
  EXPECT_TRUE(finger.last().faults().has(Fault::kDeviceSilent) ||
              finger.last().faults().has(Fault::kDeviceLost));
  expect_drive_off(finger, 400);
}

TEST_P(PressedCase, BrownoutAndHangStopTheMotor) {
  for (const FaultKind kind : {FaultKind::kBrownOut, FaultKind::kHang}) {
    fault(finger, kind, 0.3);
    finger.tick();
    EXPECT_FALSE(finger.board().drives());
    EXPECT_LE(until_fault(finger, 100), 12);
    EXPECT_TRUE(finger.last().faults().has(Fault::kDeviceSilent));
    expect_return(finger);
  }
}

TEST_P(PressedCase, AnUnpluggedBoardStopsItself) {
  fault(finger, FaultKind::kUnplug, 0.3);
  EXPECT_LE(until_fault(finger, 100), 12);
  EXPECT_TRUE(finger.last().faults().has(Fault::kDeviceLost));
  expect_drive_off(finger, 26);  // the board's watchdog, 25 ms
  EXPECT_EQ(finger.board().firmware().state, HB_STOPPED);
  expect_return(finger);
}

TEST_P(PressedCase, TheBoardFindsAStuckSensor) {
  fault(finger, FaultKind::kStuck, 0.4);
  EXPECT_LE(until_fault(finger, 300), 103);
  EXPECT_TRUE(finger.last().faults().has(Fault::kDeviceLost));
  EXPECT_FALSE(finger.board().drives());
  EXPECT_EQ(finger.board().firmware().state, HB_FAULT);
  expect_return(finger);
}

TEST_P(PressedCase, TheBoardFindsADeadMotor) {
  fault(finger, FaultKind::kStall, 60.0);
  // Nothing is to be found as long as friction holds what is asked for; then some seconds of the
  // integral, and 200 ms at its limit.
  until_fault(finger, 30'000);
  EXPECT_TRUE(finger.last().faults().has(Fault::kDeviceLost));
  EXPECT_FALSE(finger.board().drives());
}

TEST_P(PressedCase, DriftEndsOutOfRange) {
  const double l_x = finger.last().sensed.q[0];
  fault(finger, FaultKind::kDrift, 60.0, 0.01);
  // 10 mm/s from where it is to the end of the range and its margin; the rod may follow.
  const double end = finger.device().info().limits.q_upper[0];
  const int latest = static_cast<int>((end - l_x) / 0.01 * 1e3) + 5000;
  until_fault(finger, latest);
  EXPECT_TRUE(finger.last().faults().has(Fault::kSampleOutOfRange));
  expect_drive_off(finger, 3);
}

TEST_P(PressedCase, TheWatchdogOutlivesTheServer) {
  finger.device().kill_server();
  for (int ms = 1; ms <= 24; ++ms) finger.tick();
  EXPECT_TRUE(finger.board().drives()) << "not before its time: 25 ms";
  finger.run_ms(3);
  EXPECT_FALSE(finger.board().drives());
  EXPECT_EQ(finger.board().firmware().state, HB_STOPPED);
  EXPECT_EQ(finger.board().firmware().counters.watchdog_stops, 1u);
}

INSTANTIATE_TEST_SUITE_P(Seeds, PressedCase, ::testing::Values(1, 2, 3, 4, 5),
                         [](const auto& seed) { return "seed" + std::to_string(seed.param); });

}  // namespace
}  // namespace haptic::hw::emulator
