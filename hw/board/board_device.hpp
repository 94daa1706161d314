#pragma once
/// A board on a serial port as a device. Its I/O thread owns the port and the protocol. The loop
/// exchanges the newest reading and the newest command with that thread through mailboxes and never
/// waits for it, unless the loop ticks with the samples: then it waits on sample_signal().
///
///   real-time thread   read(): newest reading      write(): newest command, and a wake-up
///   I/O thread         polls port and wake-up; samples as they come, commands as they come
///
/// Unplugged, or silent for BoardHost::kSilence: LOST. The thread then looks for the port every
/// 200 ms; when the same board (by its serial) answers there, health is kOk again, disarmed.

#include <memory>
#include <optional>
#include <string>

#include "haptic/core/model/kinematics.hpp"
#include "hw/board/board_host.hpp"
#include "hw/board/calibration.hpp"
#include "hw/board/device_side.hpp"
#include "hw/device_config.hpp"

namespace haptic::hw {

struct BoardConfig final : DeviceConfig {
  std::string port{};     ///< "/dev/ttyACM0", a link under /dev/serial/by-id, or a pseudo-terminal
  int baud{921600};       ///< of real serial ports; USB ignores it
  std::string serial{};   ///< the board's own; empty: any board that answers
  std::string linkage{};  ///< as in Expectation
  core::VecA max_effort{};  ///< n_a, N or N m; the board's dictionary must allow at least this
  core::Duration max_silence{std::chrono::milliseconds(10)};
  std::optional<board::Calibration> calibration{};  ///< absent: readings are used as they are

  [[nodiscard]] std::unique_ptr<Device> open(std::shared_ptr<const core::Kinematics> kinematics,
                                             core::Duration longest_lateness) const override;
  [[nodiscard]] core::VecA effort() const override { return max_effort; }
  [[nodiscard]] bool has_sample_clock() const noexcept override { return true; }
  [[nodiscard]] bool may_measure_force() const noexcept override { return true; }
  [[nodiscard]] std::optional<Travel> travel() const override;
};

class BoardDevice final : public Device {
 public:
  /// Opens the port and shakes hands; blocks for at most 3 s. Throws DeviceError: the port cannot
  /// be opened (why, and what to do), no answer, a board that differs from the scene, the
  /// calibration is another board's.
  BoardDevice(const BoardConfig& config, const std::shared_ptr<const core::Kinematics>& kinematics,
              core::Duration longest_lateness);
  ~BoardDevice() override;

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return side_.info(); }
  void read(core::TimePoint now, core::DeviceReading& reading) noexcept override;
  void write(core::TimePoint now, const Command& command) noexcept override;
  [[nodiscard]] SampleSignal* sample_signal() noexcept override;
  void close() noexcept override;
  [[nodiscard]] std::vector<LinkCount> link_counts() const override;

  /// Counters of the link, a moment ago. Any thread but the real-time one.
  [[nodiscard]] board::HostCounters counters() const;

 private:
  class Io;
  board::DeviceSide side_;
  std::unique_ptr<Io> io_;
};

}  // namespace haptic::hw
