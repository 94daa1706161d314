#pragma once
/// An emulated board as a device in virtual time: the host's side of the protocol, the link, the
/// firmware and the rig in one thread, moved by the `now` of read(). The same seed and the same
/// calls give the same bits. It is a BoardDevice without a port and without a thread.

#include <memory>
#include <optional>

#include "hw/board/board_device.hpp"
#include "hw/emulator/emulated_board.hpp"

namespace haptic::hw::emulator {

class VirtualBoard final : public Device {
 public:
  /// Port and baud of `config` are ignored. Shakes hands within the first 100 ms of virtual time,
  /// which begins with the first read(). Throws DeviceError as BoardDevice does.
  VirtualBoard(const EmulatorConfig& board, const HandIntent& intent, const BoardConfig& config,
               const std::shared_ptr<const core::Kinematics>& kinematics);

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return side_.info(); }
  /// Lets the board's time pass until `now`. If `now` jumps, 100 ms are simulated and the rest is
  /// skipped.
  void read(core::TimePoint now, core::DeviceReading& reading) noexcept override;
  void write(core::TimePoint now, const Command& command) noexcept override;
  void close() noexcept override;

  /// Acts as if the server had been killed: from now on nothing is sent to the board.
  void kill_server() noexcept { killed_ = true; }
  [[nodiscard]] EmulatedBoard& board() noexcept { return board_; }
  [[nodiscard]] const EmulatedBoard& board() const noexcept { return board_; }
  [[nodiscard]] const board::HostCounters& counters() const noexcept { return host_.counters(); }

 private:
  void pass(core::TimePoint now);
  void pass_until(core::TimePoint now);
  void send();

  EmulatedBoard board_;
  board::DeviceSide side_;
  board::BoardHost host_;
  std::optional<core::TimePoint> start_{};
  std::uint64_t elapsed_us_{0};
  bool plugged_{true};
  bool killed_{false};
};

}  // namespace haptic::hw::emulator
