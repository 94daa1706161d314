/// The host's side of the protocol against the board's own firmware, in virtual time.
#include "hw/board/board_host.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "virtual_link.hpp"

namespace haptic::hw::board {
namespace {

using namespace std::chrono_literals;
using emulator::EmulatorConfig;
using emulator::FaultKind;
using test::VirtualLink;
using Stage = BoardHost::Stage;

TEST(BoardHost, OpensTheBoardItExpects) {
  VirtualLink link;
  link.run(5ms);
  EXPECT_EQ(link.host.stage(), Stage::kOpen);
  EXPECT_EQ(link.host.identity().serial, "EMULATOR-1");
  EXPECT_TRUE(link.host.reading().open);
  EXPECT_NEAR(link.host.reading().q[0], link.board.rig().actuator().x(), 1e-4);
}

TEST(BoardHost, RepeatsHelloUntilItIsAnswered) {
  VirtualLink link;
  link.mute = true;
  link.run(450ms);
  EXPECT_EQ(link.host.stage(), Stage::kGreeting);
  link.mute = false;
  link.run(105ms);
  EXPECT_EQ(link.host.stage(), Stage::kOpen);
}

std::string refusal(const Expectation& expected, const EmulatorConfig& config = {}) {
  VirtualLink link(config, expected);
  link.arm(5.0);
  link.run(300ms);
  EXPECT_EQ(link.host.stage(), Stage::kRefused);
  EXPECT_EQ(link.board.firmware().state, HB_DISARMED);
  EXPECT_FALSE(link.host.reading().open);
  return link.host.refusal();
}

TEST(BoardHost, RefusesABoardUnlikeTheScene) {
  const struct {
    std::function<void(Expectation&)> change;
    const char* says;
  } table[] = {
      {[](Expectation& e) { e.dofs[1].name = "q_C"; }, "DoF 1 is called 'q_B'; must be 'q_C'"},
      {[](Expectation& e) { e.dofs[0].unit = core::Unit::kRadian; },
       "DoF 0 is in m; must be in rad"},
      {[](Expectation& e) { e.dofs[0].actuated = false; },
       "DoF 0 is actuated; must be sensed only"},
      {[](Expectation& e) { e.dofs.pop_back(); }, "has 2 DoF(s); must have 1"},
      {[](Expectation& e) { e.max_effort[0] = 51.0; },
       "DoF 0 max effort = 50: must be at least max_effort of the scene, 51"},
      {[](Expectation& e) { e.serial = "OTHER"; }, "its serial = 'EMULATOR-1': must be 'OTHER'"},
  };
  for (const auto& [change, says] : table) {
    Expectation e = test::expect_finger();
    change(e);
    EXPECT_EQ(refusal(e), says);
  }
}

TEST(BoardHost, AShortWatchdogIsRefused) {
  EmulatorConfig config{.watchdog_us = 20000};
  EXPECT_EQ(refusal(test::expect_finger(), config),
            "its watchdog = 20 ms: must be longer than loop_late_fault, 20 ms");
  config.watchdog_us = 20001;
  VirtualLink link(config);
  link.run(5ms);
  EXPECT_EQ(link.host.stage(), Stage::kOpen);
}

TEST(BoardHost, NoSampleIsLost) {
  VirtualLink link;
  link.run(10ms);
  const HostCounters before = link.host.counters();
  link.run(2s);
  EXPECT_NEAR(static_cast<double>(link.host.counters().states - before.states), 2000.0, 1.0);
  EXPECT_EQ(link.host.counters().lost, 0U);
  EXPECT_EQ(link.host.counters().bad_crc + link.host.counters().malformed, 0U);
}

TEST(BoardHost, AnArmingNeedsItsNonce) {
  VirtualLink link;
  link.run(10ms);
  link.arm(3.0);
  link.run(5ms);
  EXPECT_TRUE(link.armed());
  EXPECT_TRUE(link.board.drives());
  EXPECT_FLOAT_EQ(static_cast<float>(link.board.reference()), 3.0F);
  link.disarm();
  link.run(2ms);
  EXPECT_FALSE(link.armed());
  EXPECT_FALSE(link.board.drives());
}

TEST(BoardHost, AsksAgainIfArmWasLost) {
  VirtualLink link;
  link.run(10ms);
  link.mute = true;
  link.arm();
  link.run(10ms);
  link.mute = false;  // want() was not called either, but poll() was
  link.run(BoardHost::kAgain + 5ms);
  EXPECT_TRUE(link.armed());
}

TEST(BoardHost, AWatchdogStopLastsUntilDisarmed) {
  VirtualLink link;
  link.run(10ms);
  link.arm(3.0);
  link.run(10ms);
  link.mute = true;
  link.run(24ms);
  EXPECT_TRUE(link.board.drives());
  link.run(3ms);
  EXPECT_FALSE(link.board.drives());
  EXPECT_TRUE(link.host.reading().broken);
  EXPECT_FALSE(link.armed());
  link.mute = false;
  link.run(500ms);
  EXPECT_FALSE(link.board.drives()) << "commands of the old arming revived it";
  EXPECT_TRUE(link.host.reading().broken);
  link.disarm();
  link.run(5ms);
  EXPECT_FALSE(link.host.reading().broken);
  link.arm(2.0);
  link.run(5ms);
  EXPECT_TRUE(link.armed());
  EXPECT_TRUE(link.board.drives());
  EXPECT_EQ(link.board.firmware().counters.watchdog_stops, 1U);
}

TEST(BoardHost, ABrownOutEndsDisarmed) {
  EmulatorConfig config{.faults = {{FaultKind::kBrownOut, 0.1, 0.05, 0.0}}};
  VirtualLink link(config);
  link.run(10ms);
  link.arm(3.0);
  link.run(85ms);
  EXPECT_TRUE(link.armed());
  const std::uint64_t last = link.host.reading().seq;
  link.run(200ms);
  EXPECT_LE(link.host.reading().seq, last + 5) << "a board without a session speaks";
  link.run(200ms);  // kSilence is over
  EXPECT_TRUE(link.host.reading().open);
  EXPECT_EQ(link.host.counters().handshakes, 2U);
  EXPECT_FALSE(link.armed());
  EXPECT_FALSE(link.board.drives()) << "nobody asked anew";
  link.disarm();
  link.run(2ms);
  link.arm(1.0);
  link.run(5ms);
  EXPECT_TRUE(link.armed());
}

/// Of boards without a serial number any answers to it: what the loop was built with must hold too.
TEST(BoardHost, AReplugNeedsTheSameBoard) {
  EmulatorConfig nameless{.serial = ""};
  EmulatorConfig same = nameless, other_serial = nameless, other_control = nameless;
  same.seed = 5;
  other_serial.serial = "OTHER";
  other_control.control = emulator::BoardControl::kPosition;
  const auto refusal_after_replug = [&](const EmulatorConfig& next) {
    const Intent still{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
    emulator::EmulatedBoard board(next, still, test::finger());
    VirtualLink link(nameless);
    link.run(10ms);
    EXPECT_EQ(link.host.stage(), BoardHost::Stage::kOpen);
    link.host.insist_on(link.host.identity());
    link.replug(board);
    link.run(200ms);
    EXPECT_EQ(link.host.reading().open, link.host.refusal().empty());
    return link.host.refusal();
  };
  EXPECT_EQ(refusal_after_replug(same), "");
  EXPECT_EQ(refusal_after_replug(other_serial),
            "its serial = 'OTHER': must be '', as before the port was lost");
  // It takes positions where the other closed a force loop: the protocol's bits are 1, 2 and 4.
  EXPECT_EQ(refusal_after_replug(other_control),
            "its capabilities = 6: must be 3, as before the port was lost");
}

TEST(BoardHost, AStuckSensorIsAFault) {
  EmulatorConfig config{.faults = {{FaultKind::kStuck, 0.1, 0.4, 0.0}}};
  VirtualLink link(config);
  link.arm(1.0);
  link.run(150ms);
  EXPECT_FALSE(link.host.reading().broken);
  link.run(100ms);
  EXPECT_TRUE(link.host.reading().broken);
  EXPECT_FALSE(link.board.drives());
  EXPECT_EQ(link.board.firmware().faults, HB_SENSOR_STUCK);
}

TEST(BoardHost, EveryMissingFrameIsCounted) {
  EmulatorConfig config{.drop = 3e-4, .corrupt = 3e-4};
  VirtualLink link(config);
  link.arm(1.0);
  link.run(5s);
  const HostCounters& n = link.host.counters();
  ASSERT_EQ(n.handshakes, 1U);
  // What the board made since the session is what came whole and what is known to be missing. One
  // frame may be on its way, and the one of the newest number may be damaged.
  const std::uint64_t made = link.board.firmware().tx_seq;
  EXPECT_NEAR(static_cast<double>(n.frames + n.lost), static_cast<double>(made), 3.0);
  EXPECT_GT(n.lost, 50U);
  EXPECT_GT(n.bad_crc + n.malformed, 50U);
  EXPECT_EQ(n.not_newer, 0U);
  const hb_counters& board = link.board.firmware().counters;
  EXPECT_GT(board.bad_crc + board.malformed, 20U);
}

TEST(BoardHost, DamagedBytesDoNotDisarm) {
  EmulatorConfig config{.corrupt = 3e-4};
  VirtualLink link(config);
  link.arm(1.0);
  for (int i = 0; i < 500; ++i) {
    const std::uint64_t before = link.host.reading().seq;
    link.run(10ms);
    ASSERT_GT(link.host.reading().seq, before) << i;
  }
  EXPECT_TRUE(link.armed());
  EXPECT_EQ(link.board.firmware().counters.watchdog_stops, 0U);
}

TEST(BoardHost, SlowLinksKeepSamplesYoung) {
  for (const std::uint32_t period_us : {0U, 2000U}) {
    EmulatorConfig config{.link_period_us = period_us};
    VirtualLink link(config);
    link.run(100ms);
    core::Duration oldest{0};
    for (int i = 0; i < 5000; ++i) {
      link.run(1ms);
      oldest = std::max(oldest, link.now() - link.host.reading().time);
    }
    EXPECT_LE(oldest, period_us == 0 ? 2ms : 4ms);
    EXPECT_EQ(link.host.counters().lost, 0U);
  }
}

TEST(BoardHost, RoundTripSpansCommandToState) {
  VirtualLink link;
  link.run(10ms);
  link.arm(1.0);
  link.run(100ms);
  EXPECT_GE(link.host.counters().round_trip, 0ms);
  EXPECT_LE(link.host.counters().longest_round_trip, 1ms);
}

}  // namespace
}  // namespace haptic::hw::board
