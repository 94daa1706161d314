#pragma once
/// The host's side of the protocol and an emulated board, joined without a port, in virtual time.

#include <chrono>
#include <memory>
#include <utility>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/board/board_host.hpp"
#include "hw/emulator/emulated_board.hpp"

namespace haptic::test {

[[nodiscard]] inline std::shared_ptr<const core::Kinematics> finger() {
  return core::make_finger_exoskeleton({});
}

[[nodiscard]] inline hw::board::Expectation expect_finger() {
  return {.dofs = finger()->dofs(),
          .max_effort = core::VecA::Constant(1, 40.0),
          .longest_lateness = std::chrono::milliseconds(20)};
}

class VirtualLink {
 public:
  using Host = hw::board::BoardHost;

  explicit VirtualLink(const hw::emulator::EmulatorConfig& config = {},
                       hw::board::Expectation expected = expect_finger(),
                       const Eigen::Vector2d& target = Eigen::Vector2d::Zero())
      : board(config, {Eigen::Vector2d::Zero(), target}, finger()), host(std::move(expected), 7) {
    host.connect(now());
  }

  /// A tenth of a millisecond at a time; every millisecond the host passes its newest wish on.
  void run(core::Duration length) {
    for (const core::TimePoint end = now() + length; now() < end;) {
      elapsed_us_ += 100;
      plugged_->advance(elapsed_us_);
      host.receive(plugged_->take_output(), now());
      if (elapsed_us_ % 1000 == 0) {
        if (!mute) host.want(wanted, now());
        host.poll(now());
      }
      if (!mute) plugged_->receive(host.output());
      host.consume(host.output().size());
    }
  }
  void arm(double tau_a = 0.0) {
    wanted.arm = true;
    ++wanted.arming;
    wanted.tau_a = core::VecA::Constant(1, tau_a);
  }
  void disarm() { wanted.arm = false; }
  /// The port goes, and comes back with `other` behind it, which must outlive the link.
  void replug(hw::emulator::EmulatedBoard& other) {
    host.disconnect();
    plugged_ = &other;
    host.connect(now());
  }
  [[nodiscard]] core::TimePoint now() const {
    return core::TimePoint(std::chrono::hours(5) + std::chrono::microseconds(elapsed_us_));
  }
  [[nodiscard]] bool armed() const {
    return host.reading().armed != 0 && host.reading().armed == wanted.arming;
  }

  hw::emulator::EmulatedBoard board;
  Host host;
  hw::board::Wanted wanted{};
  bool mute{false};  ///< nothing reaches the board

 private:
  hw::emulator::EmulatedBoard* plugged_{&board};
  std::uint64_t elapsed_us_{0};
};

}  // namespace haptic::test
