/// The host's side of the protocol against the board's own firmware, in virtual time.
#include "hw/board/board_host.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <set>
#include <string>

#include "tests/hw/board/frames.hpp"
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
      {[](Expectation& e) { e.linkage = "finger_sign_change"; },
       "its model = 'finger_same_sign': must be 'finger_sign_change', the linkage of the scene, or "
       "no linkage's name"},
  };
  for (const auto& [change, says] : table) {
    Expectation e = test::expect_finger();
    change(e);
    EXPECT_EQ(refusal(e), says);
  }
}

TEST(BoardHost, OnlyWatchdogsInRangeAreTaken) {
  constexpr std::uint32_t k71Minutes = 4'294'967'295U;
  for (const std::uint32_t us : {20'000U, 1'000'001U, k71Minutes}) {
    EXPECT_NE(refusal(test::expect_finger(), {.watchdog_us = us})
                  .find(": must be longer than loop_late_fault, 20 ms, and at most 1000 ms"),
              std::string::npos)
        << us;
  }
  for (const std::uint32_t us : {20'001U, 1'000'000U}) {
    VirtualLink link(EmulatorConfig{.watchdog_us = us});
    link.run(5ms);
    EXPECT_EQ(link.host.stage(), Stage::kOpen) << us;
  }
}

/// Words of a board that is no emulated one: frames by hand, with the session of the host's HELLO.
class SpokenTo {
 public:
  SpokenTo() : host(test::expect_finger(), 7) {
    host.connect(now);
    session_ = heard<Hello>(HF_HELLO).value_or(Hello{}).session;
  }
  /// The last message of that type that the host has sent since the last call.
  template <typename Message>
  std::optional<Message> heard(hf_type type) {
    std::optional<Message> last;
    hf_decoder decoder{};
    for (const std::uint8_t byte : host.output()) {
      if (hf_push(&decoder, byte) != HF_FRAME) continue;
      if (decoder.type == type) last = read<Message>(test::payload_of(decoder));
    }
    host.consume(host.output().size());
    return last;
  }
  template <typename Message>
  void say(hf_type type, const Message& message) {
    const Payload payload = write(message);
    host.receive(test::wire_of(type, ++seq_, payload.view()), now);
  }
  void say(Identity identity) {
    identity.session = session_;
    say(HF_IDENTITY, identity);
    Dof l_x{.index = 0, .actuated = true, .lower = 0.0F, .upper = 0.05F, .max_effort = 50.0F};
    l_x.max_rate = 0.032F;
    l_x.name = "l_x";
    say(HF_DOF, l_x);
    Dof q_B{.index = 1, .radian = true, .lower = -1.3F, .upper = 0.7F};
    q_B.name = "q_B";
    say(HF_DOF, q_B);
  }
  static Identity identity() {
    return {.n_q = 2,
            .n_a = 1,
            .capabilities = HB_MEASURES_FORCE,
            .watchdog_us = 25'000,
            .sample_period_us = 1000};
  }

  core::TimePoint now{5h};
  BoardHost host;

 private:
  std::uint32_t session_{0}, seq_{0};
};

TEST(BoardHost, ActuatorsAreThoseOfTheDictionary) {
  for (const std::uint8_t n_a : {std::uint8_t{0}, std::uint8_t{2}}) {
    SpokenTo board;
    Identity said = SpokenTo::identity();
    said.n_a = n_a;
    board.say(said);
    EXPECT_EQ(board.host.stage(), Stage::kRefused);
    EXPECT_EQ(board.host.refusal(), "its n_a = " + std::to_string(n_a) +
                                        ": must be 1, the actuated DoFs of its dictionary");
  }
  SpokenTo board;
  board.say(SpokenTo::identity());
  EXPECT_EQ(board.host.stage(), Stage::kOpen);
}

TEST(BoardHost, TheDictionaryBoundsADrivesDamping) {
  SpokenTo board;
  board.say(SpokenTo::identity());
  const Introduction said = board.host.introduction();
  ASSERT_EQ(said.drive_damping.size(), 1);
  EXPECT_NEAR(said.drive_damping[0], 3125.0, 0.01) << "L16: 100 N stall over 32 mm/s, net";
}

TEST(BoardHost, EveryArmingHasAnotherNonce) {
  VirtualLink link;
  link.run(10ms);
  std::set<std::uint32_t> nonces;
  for (int arming = 1; arming <= 20; ++arming) {
    link.arm(1.0);
    link.run(5ms);
    ASSERT_TRUE(link.armed()) << arming;
    nonces.insert(link.board.firmware().nonce);
    if (arming % 2 == 0) link.disarm();  // else the next one follows without a DISARM between
    link.run(5ms);
  }
  EXPECT_EQ(nonces.size(), 20u);
  EXPECT_EQ(nonces.count(0), 0u);
}

/// A board that is deaf to the second ARM goes on under the first one.
TEST(BoardHost, AFormerArmingIsNotArmed) {
  SpokenTo board;
  board.say(SpokenTo::identity());
  const auto asked = [&](bool arm, std::uint32_t arming) {
    board.host.want({.arm = arm, .arming = arming, .tau_a = core::VecA::Zero(1)}, board.now);
    return board.heard<Arm>(HF_ARM).value_or(Arm{}).nonce;
  };
  const auto says_armed = [&](std::uint32_t nonce) {
    State state{.nonce = nonce, .state = HB_ARMED, .n_q = 2, .n_f = 1};
    board.say(HF_STATE, state);
    return board.host.reading().armed;
  };
  const std::uint32_t first = asked(true, 1);
  EXPECT_EQ(says_armed(first), 1u);
  static_cast<void>(asked(false, 1));
  const std::uint32_t second = asked(true, 2);
  EXPECT_NE(first, second);
  EXPECT_EQ(says_armed(first), 0u);
  EXPECT_EQ(says_armed(second), 2u);
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

/// Any board without a serial number answers to it: what the loop was built with must hold too.
TEST(BoardHost, AReplugNeedsTheSameBoard) {
  EmulatorConfig nameless{.serial = ""};
  EmulatorConfig same = nameless, other_serial = nameless, other_control = nameless;
  same.seed = 5;
  other_serial.serial = "OTHER";
  other_control.control = emulator::BoardControl::kPosition;
  const auto refusal_after_replug = [&](const EmulatorConfig& next) {
    const HandIntent still{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
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

TEST(BoardHost, EveryMissingFrameIsCounted) {
  EmulatorConfig config{.drop = 3e-4, .corrupt = 3e-4};
  VirtualLink link(config);
  link.arm(1.0);
  link.run(5s);
  const HostCounters& n = link.host.counters();
  // The frames that the board made since the session came whole or are known to be missing. One
  // frame may be on its way, and the one of the newest number may be damaged.
  const std::uint64_t made = link.board.firmware().tx_seq;
  EXPECT_NEAR(static_cast<double>(n.frames + n.lost), static_cast<double>(made), 3.0);
  EXPECT_GT(n.lost, 50U);
  EXPECT_GT(n.bad_crc + n.malformed, 50U);
  EXPECT_EQ(n.not_newer, 0U);
  const hb_counters& board = link.board.firmware().counters;
  EXPECT_GT(board.bad_crc + board.malformed, 20U);
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
    EXPECT_NEAR(static_cast<double>(link.host.reading().seq), 5100.0, 10.0);
  }
}

}  // namespace
}  // namespace haptic::hw::board
