/// The board's state machine in virtual time, spoken to with the server's own messages.
#include "hw/firmware/haptic_board.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "hw/board/messages.hpp"
#include "tests/hw/board/frames.hpp"

namespace haptic::hw::board {
namespace {

constexpr std::uint64_t kWatchdogUs = 10000;

const hb_dof kDofs[2] = {{"l_x", false, true, 0.0F, 0.05F, 40.0F, 0.032F, 100},
                         {"q_B", true, false, -1.3F, 0.7F, 0.0F, 0.0F, 0}};

/// A board and what it sent; time moves only where a test says so.
class FirmwareBoard : public testing::Test {
 protected:
  FirmwareBoard() { power_on(); }

  void power_on() { hb_init(&board_, &config_, &FirmwareBoard::keep, this); }

  template <typename Message>
  void send(hf_type type, const Message& message) {
    send_as(++seq_, type, message);
  }
  template <typename Message>
  void send_as(std::uint32_t seq, hf_type type, const Message& message) {
    receive(test::wire_of(type, seq, write(message).view()));
  }
  void receive(const std::vector<std::uint8_t>& wire) {
    for (const std::uint8_t byte : wire) hb_receive(&board_, byte, now_);
  }
  void hello(std::uint32_t session = 77) { send(HF_HELLO, Hello{1, session}); }
  void arm(std::uint32_t nonce = 5) { send(HF_ARM, Arm{nonce}); }
  static Command wish(float value, std::uint32_t nonce = 5, std::uint8_t kind = HB_FORCE) {
    return {nonce, kind, 1, {value}};
  }
  void command(float force, std::uint32_t nonce = 5) { send(HF_COMMAND, wish(force, nonce)); }
  /// A session, armed under nonce 5, with this force commanded.
  void press(float force) {
    hello();
    arm();
    command(force);
  }
  /// Command to the drive; empty: off.
  std::optional<float> reference() {
    float value = -1.0F;
    hb_kind kind = HB_FORCE;
    const bool on = hb_reference(&board_, now_, &value, &kind);
    EXPECT_TRUE(on || value == 0.0F) << value;
    return on ? std::optional<float>(value) : std::nullopt;
  }
  /// A sample with a reading that moves; returns the State it sent, if any.
  std::optional<State> sample(std::uint8_t faults = 0) {
    const float q[2] = {0.01F + 1e-5F * static_cast<float>(++samples_ % 7), 0.2F};
    const float force[1] = {1.0F};
    state_.reset();
    hb_sample(&board_, now_, q, force, faults);
    return state_;
  }

  std::uint64_t now_{1'000'000};
  std::uint32_t seq_{0};
  hb_config config_{"T-1",       "test", {0, 1, 0}, HB_FORCE_LOOP | HB_MEASURES_FORCE,
                    kWatchdogUs, 1000,   kDofs,     2};
  hb_board board_{};
  bool room_{true};
  std::vector<std::uint8_t> sent_{};  ///< types of the frames
  std::optional<State> state_{};
  std::optional<Identity> identity_{};

 private:
  static bool keep(void* context, const std::uint8_t* bytes, size_t length) {
    auto& self = *static_cast<FirmwareBoard*>(context);
    if (!self.room_) return false;
    for (std::size_t i = 0; i < length; ++i) {
      if (hf_push(&self.decoder_, bytes[i]) != HF_FRAME) continue;
      const auto payload = test::payload_of(self.decoder_);
      self.sent_.push_back(self.decoder_.type);
      if (self.sent_.back() == HF_STATE) self.state_ = read<State>(payload);
      if (self.sent_.back() == HF_IDENTITY) self.identity_ = read<Identity>(payload);
    }
    return true;
  }
  hf_decoder decoder_{};
  int samples_{0};
};

TEST_F(FirmwareBoard, SilentUntilHello) {
  EXPECT_FALSE(sample());
  hello();
  EXPECT_TRUE(sample());
}

TEST_F(FirmwareBoard, AnotherVersionGetsNoSession) {
  send(HF_HELLO, Hello{2, 77});
  ASSERT_TRUE(identity_);
  EXPECT_EQ(identity_->version, 1);
  EXPECT_FALSE(sample());
}

TEST_F(FirmwareBoard, FollowsOnlyArmedAndCommanded) {
  hello();
  command(3.0F);
  EXPECT_FALSE(reference());
  arm();
  EXPECT_FALSE(reference());  // nothing to follow yet
  command(3.0F);
  EXPECT_EQ(reference(), 3.0F);
  send(HF_DISARM, Disarm{});
  EXPECT_FALSE(reference());
}

TEST_F(FirmwareBoard, ReferencesAreClamped) {
  hello();
  arm();
  command(1000.0F);
  EXPECT_EQ(reference(), 40.0F);
  command(-1000.0F);
  EXPECT_EQ(reference(), -40.0F);
}

TEST_F(FirmwareBoard, TheWatchdogStopsOnTime) {
  press(3.0F);
  now_ += kWatchdogUs;
  EXPECT_EQ(reference(), 3.0F);
  now_ += 1;
  EXPECT_FALSE(reference());
  ASSERT_TRUE(sample());
  EXPECT_EQ(state_->state, HB_STOPPED);
  EXPECT_EQ(board_.counters.watchdog_stops, 1U);
}

TEST_F(FirmwareBoard, TheWatchdogRunsFromArmOn) {
  hello();
  arm();
  now_ += kWatchdogUs + 1;
  command(3.0F);
  EXPECT_FALSE(reference());
}

TEST_F(FirmwareBoard, LateCommandsDoNotRevive) {
  press(3.0F);
  now_ += kWatchdogUs + 1;
  command(3.0F);  // the first thing that the board sees after its time
  EXPECT_FALSE(reference());
  EXPECT_EQ(board_.counters.wrong_nonce, 1U);
}

TEST_F(FirmwareBoard, OnlyANewNonceRearms) {
  hello();
  arm(5);
  now_ += kWatchdogUs + 1;
  EXPECT_FALSE(reference());
  arm(5);
  send(HF_DISARM, Disarm{});
  EXPECT_EQ(sample()->state, HB_STOPPED);
  arm(6);
  command(1.0F, 5);  // of the arming before: still in some buffer
  EXPECT_FALSE(reference());
  command(2.0F, 6);
  EXPECT_EQ(reference(), 2.0F);
}

TEST_F(FirmwareBoard, OnlyCommandsRestartTheWatchdog) {
  press(3.0F);
  for (int i = 0; i < 20; ++i) {
    now_ += 1000;
    hello();            // a host that lives, but commands nothing
    command(3.0F, 99);  // wrong nonce
    command(std::numeric_limits<float>::quiet_NaN());
    Command two{5, HB_FORCE, 2, {}};
    send(HF_COMMAND, two);
  }
  EXPECT_EQ(sample()->state, HB_STOPPED);
  EXPECT_EQ(board_.counters.malformed, 40U);
}

TEST_F(FirmwareBoard, OldFramesAreDroppedAndCounted) {
  press(1.0F);
  const std::uint32_t last = seq_;
  send_as(last, HF_COMMAND, wish(9.0F));
  send_as(last - 1, HF_COMMAND, wish(9.0F));
  EXPECT_EQ(reference(), 1.0F);
  EXPECT_EQ(board_.counters.not_newer, 2U);
}

TEST_F(FirmwareBoard, CorruptFramesAreDroppedAndCounted) {
  press(1.0F);
  std::vector<std::uint8_t> wire = test::wire_of(HF_COMMAND, ++seq_, write(wish(9.0F)).view());
  wire[wire.size() - 3] ^= 0x10;  // within the CRC
  receive(wire);
  EXPECT_EQ(reference(), 1.0F);
  EXPECT_EQ(board_.counters.bad_crc, 1U);
  command(2.0F);
  EXPECT_EQ(reference(), 2.0F);
}

TEST_F(FirmwareBoard, ANewSessionDisarms) {
  hello(1);
  arm();
  command(3.0F);
  send_as(1, HF_HELLO, Hello{1, 2});  // its numbers begin at 1 again
  EXPECT_FALSE(reference());
  EXPECT_EQ(sample()->state, HB_DISARMED);
  seq_ = 1;
  arm(6);
  command(1.0F, 6);
  EXPECT_EQ(reference(), 1.0F);
}

TEST_F(FirmwareBoard, ARepeatedHelloOnlyAnswers) {
  hello(1);
  arm();
  command(3.0F);
  identity_.reset();
  hello(1);
  EXPECT_TRUE(identity_);
  EXPECT_EQ(reference(), 3.0F);
}

TEST_F(FirmwareBoard, AFaultStopsAndIsLatched) {
  press(3.0F);
  EXPECT_EQ(sample(HB_FORCE_OVER_LIMIT)->state, HB_FAULT);
  EXPECT_EQ(state_->faults, HB_FORCE_OVER_LIMIT);
  EXPECT_FALSE(reference());
  arm(6);  // the cause persists
  EXPECT_EQ(sample(HB_FORCE_OVER_LIMIT)->state, HB_FAULT);
  EXPECT_EQ(sample(0)->state, HB_FAULT);
  EXPECT_EQ(state_->faults, 0);
  arm(7);
  EXPECT_EQ(sample(0)->state, HB_ARMED);
}

TEST_F(FirmwareBoard, ARepeatingSensorIsStuck) {
  hello();
  const float q[2] = {0.01F, 0.2F};
  // The first reading, and 99 that repeat it.
  for (int i = 0; i < 100; ++i) hb_sample(&board_, now_ += 1000, q, nullptr, 0);
  EXPECT_EQ(state_->state, HB_DISARMED);
  hb_sample(&board_, now_ += 1000, q, nullptr, 0);
  EXPECT_EQ(state_->state, HB_FAULT);
  EXPECT_EQ(state_->faults, HB_SENSOR_STUCK);
  EXPECT_EQ(sample()->faults, 0);  // it moves again
}

TEST_F(FirmwareBoard, AStateNamesItsCommand) {
  hello();
  EXPECT_EQ(sample()->command_seq, 0U);
  EXPECT_EQ(state_->command_age_us, 65535);
  arm();
  command(1.0F);
  now_ += 300;
  ASSERT_TRUE(sample());
  EXPECT_EQ(state_->command_seq, seq_);
  EXPECT_EQ(state_->command_age_us, 300);
  EXPECT_EQ(state_->time_us, now_);
  EXPECT_EQ(state_->nonce, 5U);
  EXPECT_EQ(state_->force[0], 1.0F);
}

TEST_F(FirmwareBoard, FramesWithoutRoomAreCounted) {
  hello();
  ASSERT_TRUE(sample());  // brings the first COUNTERS along
  room_ = false;
  for (int i = 0; i < 3; ++i) static_cast<void>(sample());
  room_ = true;
  const std::uint32_t before = board_.tx_seq;
  ASSERT_TRUE(sample());
  EXPECT_EQ(board_.counters.states_dropped, 3U);
  EXPECT_EQ(board_.tx_seq, before + 1);
}

TEST_F(FirmwareBoard, SendsCountersTenTimesASecond) {
  hello();
  sent_.clear();
  for (int i = 0; i < 1000; ++i) {
    now_ += 1000;
    static_cast<void>(sample());
  }
  EXPECT_EQ(std::count(sent_.begin(), sent_.end(), HF_STATE), 1000);
  EXPECT_EQ(std::count(sent_.begin(), sent_.end(), HF_COUNTERS), 10);
}

TEST_F(FirmwareBoard, PositionsNeedTheCapability) {
  hello();
  arm();
  const Command position = wish(0.02F, 5, HB_POSITION);
  send(HF_COMMAND, position);
  EXPECT_FALSE(reference());
  config_.capabilities |= HB_POSITION_COMMAND;
  send(HF_COMMAND, position);
  EXPECT_EQ(reference(), 0.02F);
}

}  // namespace
}  // namespace haptic::hw::board
