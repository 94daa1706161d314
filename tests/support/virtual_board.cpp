#include "tests/support/virtual_board.hpp"

#include <algorithm>

#include "haptic/core/error.hpp"

namespace haptic::hw::emulator {
namespace {

constexpr std::uint64_t kAdvanceUs = 100, kPollUs = 1000, kHandshakeUs = 100'000;
constexpr std::uint64_t kLongestJumpUs = 100'000;

}  // namespace

VirtualBoard::VirtualBoard(const EmulatorConfig& board, const HandIntent& intent,
                           const BoardConfig& config,
                           const std::shared_ptr<const core::Kinematics>& kinematics)
    : board_(board, intent, kinematics),
      side_(config, kinematics, core::Duration{0}),
      host_(side_.expectation(), board.seed) {
  const core::TimePoint before(std::chrono::microseconds(0));
  host_.connect(before);
  while (host_.stage() == board::BoardHost::Stage::kGreeting && elapsed_us_ < kHandshakeUs) {
    pass_until(before + std::chrono::microseconds(elapsed_us_ + kAdvanceUs));
  }
  if (host_.stage() != board::BoardHost::Stage::kOpen) {
    throw core::DeviceError("emulated board refused: " + host_.refusal());
  }
  host_.insist_on(host_.identity());
  side_.identify(host_.introduction());
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
  send();
}

void VirtualBoard::send() {
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
  side_.read(host_.reading(), reading);
}

void VirtualBoard::write(core::TimePoint now, const Command& command) noexcept {
  const board::Wanted& wanted = side_.write(command);
  if (killed_) return;
  host_.want(wanted, now);
  send();
}

void VirtualBoard::close() noexcept {
  write(core::TimePoint{}, {});
}

}  // namespace haptic::hw::emulator
