#pragma once
/// The interface between a haptic device and the real-time loop.
///
///            DeviceConfig::open()          arm wanted            handshake done
///   (none) ----------------> DISARMED ----------------> ARMING ----------------> ARMED
///                               ^                                                  |
///                               +---------- arm no longer wanted, close() ---------+
///   Any state -> LOST: health kLost in every reading from then on, until the device returns.
///
/// One thread, the real-time loop, calls read() and write(); neither blocks, allocates, locks, logs
/// or throws. Construction and close() belong to the main thread.

#include <cstdint>
#include <string>
#include <vector>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "haptic/core/tick/tick_input.hpp"
#include "hw/sample_signal.hpp"

namespace haptic::hw {

struct DeviceInfo {
  std::string kind{};    ///< of its folder in hw/: "simulated", "replay", "board", ...
  std::string model{};   ///< for people: what it is, and what it was opened from
  std::string serial{};  ///< unique per device; empty if it has none
  std::vector<core::DofSpec> dofs{};
  core::DeviceLimits limits{};
  /// Warnings from opening the device, for people; one line each.
  std::vector<std::string> notes{};
  std::string calibrated{};       ///< date of the calibration in use; empty: none
  bool measures_force{false};     ///< samples carry tau_measured
  bool closes_force_loop{false};  ///< tau_a is the reference of a loop of its own
  bool takes_positions{false};    ///< follows Command::position
  bool moves{true};  ///< false: commands are computed and reported, nothing moves (replay)
};

/// The force command of one tick.
struct Command {
  bool arm{false};        ///< the server wants the device armed
  core::VecA tau_a{};     ///< n_a; N or N m; all zero unless armed
  core::VecA position{};  ///< n_a, m or rad: where to go, instead of tau_a; size 0: a force
};

/// Number of frames on the link since it was opened that had the same fate.
struct LinkCount {
  const char* end{""};   ///< who counted: "host", "board"
  const char* what{""};  ///< "received", "lost", "bad_crc", ...: hw/README.md, "The board device"
  std::uint64_t frames{0};
};

class Device {
 public:
  virtual ~Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  [[nodiscard]] virtual const DeviceInfo& info() const noexcept = 0;

  /// Real-time thread, once a tick, before write(). Never blocks. If there is no new sample,
  /// `reading` keeps the previous one and `fresh` is false. reading.health reports failures.
  virtual void read(core::TimePoint now, core::DeviceReading& reading) noexcept = 0;

  /// Real-time thread, once a tick. Never blocks. A device that is not armed ignores tau_a.
  virtual void write(core::TimePoint now, const Command& command) noexcept = 0;

  /// A device that samples by its own clock posts each new sample here, so that the loop can tick
  /// when a sample arrives. Null if read() always has a sample (simulated, replay). Lives as long
  /// as the device.
  [[nodiscard]] virtual SampleSignal* sample_signal() noexcept { return nullptr; }

  /// Main thread, after the loop ended: zero force, disarm, release what was opened. May block for
  /// at most 200 ms. Idempotent.
  virtual void close() noexcept = 0;

  /// Recent counts of the frames on the link, also after close(); empty if there is no link. Any
  /// thread except the real-time one.
  [[nodiscard]] virtual std::vector<LinkCount> link_counts() const { return {}; }

 protected:
  Device() = default;
};

}  // namespace haptic::hw
