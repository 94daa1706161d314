#pragma once
/// An emulated board as a device in virtual time: the host's side of the protocol, the link, the
/// firmware and the rig in one thread, moved by the `now` of read(). Same seed and same calls: same
/// bits. What BoardDevice does with a port and a thread, without either.

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "hw/board/board_device.hpp"
#include "hw/board/board_host.hpp"
#include "hw/device.hpp"
#include "hw/emulator/emulated_board.hpp"

namespace haptic::hw::emulator {

class VirtualBoard final : public Device {
 public:
  /// `config`: as of a real port, which (with baud) is not looked at. Shakes hands within the first
  /// 100 ms of virtual time, which begins with the first read(). Throws DeviceError as BoardDevice.
  VirtualBoard(const EmulatorConfig& board, const Intent& intent, const BoardConfig& config,
               const std::shared_ptr<const core::Kinematics>& kinematics);

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  /// Lets the board's time pass until `now`. Of a jump 100 ms are simulated, the rest is skipped.
  void read(core::TimePoint now, core::DeviceReading& reading) noexcept override;
  void write(core::TimePoint now, const Command& command) noexcept override;
  void close() noexcept override;

  /// The server is gone (killed): nothing it would say reaches the board from now on.
  void kill_server() noexcept { killed_ = true; }
  [[nodiscard]] EmulatedBoard& board() noexcept { return board_; }
  [[nodiscard]] const EmulatedBoard& board() const noexcept { return board_; }
  [[nodiscard]] const board::HostCounters& counters() const noexcept { return host_.counters(); }

 private:
  void pass(core::TimePoint now);
  void pass_until(core::TimePoint now);

  EmulatedBoard board_;
  board::BoardHost host_;
  core::DofLayout layout_;
  std::optional<board::Calibration> calibration_;
  DeviceInfo info_{};
  board::Wanted wanted_{};
  std::uint64_t last_seq_{0};
  std::optional<core::TimePoint> start_{};
  std::uint64_t elapsed_us_{0};
  bool plugged_{true};
  bool killed_{false};
};

}  // namespace haptic::hw::emulator
