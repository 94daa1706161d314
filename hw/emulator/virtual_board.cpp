#include "hw/emulator/virtual_board.hpp"

#include <algorithm>

#include "haptic/core/error.hpp"
#include "hw/board/board_reading.hpp"
#include "hw/device_limits.hpp"

namespace haptic::hw::emulator {
namespace {

constexpr std::uint64_t kAdvanceUs = 100, kPollUs = 1000, kHandshakeUs = 100'000;
constexpr std::uint64_t kLongestJumpUs = 100'000;

board::Expectation expectation(const BoardConfig& config, const core::Kinematics& kinematics) {
  return {kinematics.dofs(), config.max_effort, core::Duration{0}, config.serial};
}

}  // namespace

VirtualBoard::VirtualBoard(const EmulatorConfig& board, const Intent& intent,
                           const BoardConfig& config,
                           const std::shared_ptr<const core::Kinematics>& kinematics)
    : board_(board, intent, kinematics),
      host_(expectation(config, *kinematics), board.seed),
      layout_(kinematics->layout()),
      calibration_(config.calibration) {
  info_.kind = "board";
  info_.dofs = kinematics->dofs();
  info_.limits = device_limits(*kinematics, config.max_effort);
  info_.limits.max_silence = config.max_silence;
  wanted_.tau_a = core::VecA::Zero(layout_.n_a());
  const core::TimePoint before(std::chrono::microseconds(0));
  host_.connect(before);
  while (host_.stage() == board::BoardHost::Stage::kGreeting && elapsed_us_ < kHandshakeUs) {
    pass_until(before + std::chrono::microseconds(elapsed_us_ + kAdvanceUs));
  }
  if (host_.stage() != board::BoardHost::Stage::kOpen) {
    throw core::DeviceError("emulated board refused: " + host_.refusal());
  }
  const board::Identity& identity = host_.identity();
  host_.insist_on(identity);
  info_.model = identity.model;
  info_.serial = identity.serial;
  info_.limits.sample_period = std::chrono::microseconds(identity.sample_period_us);
  info_.measures_force = (identity.capabilities & board::kMeasuresForce) != 0;
  info_.closes_force_loop = (identity.capabilities & board::kForceLoop) != 0;
  info_.takes_positions = (identity.capabilities & board::kPositionCommand) != 0;
  if (!calibration_) return;
  board::check(*calibration_, *kinematics, info_.serial, info_.measures_force);
  board::apply(*calibration_, info_.limits);
  info_.calibrated = calibration_->date;
}

void VirtualBoard::pass(core::TimePoint now) {
  board_.advance(elapsed_us_);
  const auto bytes = board_.take_output();
  if (board_.plugged() != plugged_) {  // as the I/O thread sees a port go and come back
    plugged_ = board_.plugged();
    if (plugged_) {
      host_.connect(now);
    } else {
      host_.disconnect();
    }
  }
  if (killed_) return;
  if (plugged_) host_.receive(bytes, now);
  if (elapsed_us_ % kPollUs == 0) host_.poll(now);
  board_.receive(host_.output());
  host_.consume(host_.output().size());
}

void VirtualBoard::pass_until(core::TimePoint now) {
  const core::TimePoint zero = start_.value_or(core::TimePoint{});
  const auto wanted = static_cast<std::uint64_t>(
      std::max<std::int64_t>(0, (now - zero) / std::chrono::microseconds(1)));
  if (wanted > elapsed_us_ + kLongestJumpUs) {
    start_ = zero + std::chrono::microseconds(wanted - elapsed_us_ - kLongestJumpUs);
    return pass_until(now);
  }
  while (elapsed_us_ + kAdvanceUs <= wanted) {
    elapsed_us_ += kAdvanceUs;
    pass(zero + std::chrono::microseconds(elapsed_us_));
  }
}

void VirtualBoard::read(core::TimePoint now, core::DeviceReading& reading) noexcept {
  // The clock of the handshake ends where that of the loop begins.
  if (!start_) start_ = now - std::chrono::microseconds(elapsed_us_);
  pass_until(now);
  board::to_reading(host_.reading(), wanted_, last_seq_, reading);
  if (calibration_ && reading.fresh) board::apply(*calibration_, reading.sample);
}

void VirtualBoard::write(core::TimePoint now, const Command& command) noexcept {
  board::to_wish(command, wanted_);
  if (calibration_) board::to_board(*calibration_, layout_, info_.closes_force_loop, wanted_);
  if (killed_) return;
  host_.want(wanted_, now);
  board_.receive(host_.output());
  host_.consume(host_.output().size());
}

void VirtualBoard::close() noexcept {
  write(core::TimePoint{}, {false, core::VecA::Zero(layout_.n_a()), {}});
}

}  // namespace haptic::hw::emulator
