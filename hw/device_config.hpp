#pragma once
/// The configuration of a device that is not open yet, and how to open it.

#include <filesystem>
#include <memory>
#include <optional>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/time.hpp"
#include "hw/device.hpp"

namespace haptic::hw {

/// The device's own dynamics per actuated DoF, without the hand, because a hand may let go. Empty
/// if they are not known or nothing moves.
struct OwnDynamics {
  core::VecA damping{};  ///< N s/m or N m s/rad
  core::VecA inertia{};  ///< kg or kg m^2
};

/// Range of the samples of each DoF, n_q; m or rad.
struct Travel {
  core::VecQ lower{}, upper{};
};

/// Base of the configurations. Each device has a configuration that declares what the server must
/// know before it opens the device. The server calls these functions and never asks which device it
/// is.
class DeviceConfig {
 public:
  virtual ~DeviceConfig() = default;

  /// Opens the device; may block. `kinematics` is not null. Throws DeviceError: a file that cannot
  /// be read (path, line, column and what is expected), a value that is not allowed, a kinematics
  /// that does not fit the device. `longest_lateness` is loop_late_fault: a device whose watchdog
  /// is not longer refuses.
  [[nodiscard]] virtual std::unique_ptr<Device> open(
      std::shared_ptr<const core::Kinematics> kinematics,
      core::Duration longest_lateness) const = 0;

  /// n_a, N or N m: the scene's force limits must not exceed it.
  [[nodiscard]] virtual core::VecA effort() const = 0;

  /// False for a simulation or a recording: a late command is harmless there, so the loop's default
  /// limits on lateness are wide, and --check-scene opens the device.
  [[nodiscard]] virtual bool is_hardware() const noexcept { return true; }
  /// The device has a sample_signal(), so it can pace the loop.
  [[nodiscard]] virtual bool has_sample_clock() const noexcept { return false; }
  /// The device may measure force, so that a scene may close a loop on it (`force_control`).
  [[nodiscard]] virtual bool may_measure_force() const noexcept { return false; }
  /// The file that the device plays, which a recording must not overwrite; empty: none.
  [[nodiscard]] virtual std::filesystem::path plays() const { return {}; }
  /// `layout`: the DoFs of its kinematics.
  [[nodiscard]] virtual OwnDynamics own_dynamics(const core::DofLayout& /*layout*/) const {
    return {};
  }
  /// Absent: the ranges of the DoFs.
  [[nodiscard]] virtual std::optional<Travel> travel() const { return std::nullopt; }

 protected:
  DeviceConfig() = default;
  DeviceConfig(const DeviceConfig&) = default;
  DeviceConfig(DeviceConfig&&) = default;
  DeviceConfig& operator=(const DeviceConfig&) = default;
  DeviceConfig& operator=(DeviceConfig&&) = default;
};

}  // namespace haptic::hw
