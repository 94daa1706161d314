#pragma once
/// A board as the loop sees it, without the way its bytes travel: BoardDevice adds a port and a
/// thread, emulator::VirtualBoard virtual time. Nothing here waits or reads a clock.

#include <memory>
#include <optional>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/tick/tick_input.hpp"
#include "hw/board/board_host.hpp"
#include "hw/board/calibration.hpp"
#include "hw/device.hpp"

namespace haptic::hw {
struct BoardConfig;
}

namespace haptic::hw::board {

class DeviceSide {
 public:
  /// Throws DeviceError: config.max_effort has another size than n_a or a value that is not > 0.
  DeviceSide(const BoardConfig& config, std::shared_ptr<const core::Kinematics> kinematics,
             core::Duration longest_lateness);

  /// The scene's requirements on the board.
  [[nodiscard]] const Expectation& expectation() const noexcept { return expectation_; }
  /// Copies what the board that answered said of itself into info(). Throws DeviceError if the
  /// calibration belongs to another board.
  void identify(const Introduction& said);
  [[nodiscard]] const DeviceInfo& info() const noexcept { return info_; }
  [[nodiscard]] DeviceInfo& info() noexcept { return info_; }

  /// The loop's view of `newest`: calibrated, fresh once per sample, and armed only under the
  /// arming that the loop asked for last.
  void read(const BoardReading& newest, core::DeviceReading& reading) noexcept;

  /// The loop's command as the wish to send. Each new arming has a new number. Without `arm` there
  /// is neither force nor position. Both are in the board's terms: positions as its sensors will
  /// read them, and forces too if the board closes the loop on its load cell.
  [[nodiscard]] const Wanted& write(const hw::Command& command) noexcept;

 private:
  std::shared_ptr<const core::Kinematics> kinematics_;
  std::optional<Calibration> calibration_;
  Expectation expectation_;
  DeviceInfo info_{};
  Wanted wanted_{};
  std::uint64_t last_seq_{0};  ///< of the newest sample that read() delivered
};

}  // namespace haptic::hw::board
