#pragma once
/// The devices there are, and how to open one.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/time.hpp"
#include "hw/board/calibration.hpp"
#include "hw/device.hpp"

namespace haptic::hw {

/// The finger exoskeleton worn on a simulated finger, core/METHOD.md#forces-at-the-finger.
struct SimulatedFingerConfig {
  std::uint64_t seed{1};
  std::filesystem::path motion_file{};  ///< joint angles the user aims at; empty: `target`
  double target_mcp{0.0};               ///< rad
  double target_pip{0.0};
  double hand_stiffness{0.6};  ///< K_h, N m/rad
  double hand_damping{0.012};  ///< B_h, N m s/rad
  double inertia_mcp{1.2e-4};  ///< kg m^2, core/METHOD.md#forces-at-the-finger
  double inertia_pip{4e-5};
  double actuator_mass{0.05};         ///< kg
  double actuator_damping{2.0};       ///< N s/m
  double actuator_friction{0.0};      ///< N, Coulomb
  double actuator_force_limit{40.0};  ///< N
  double noise_l_x{0.0};              ///< m rms
  double noise_q_B{0.0};              ///< rad rms
  double resolution_l_x{0.0};         ///< m; 0: none
  double resolution_q_B{0.0};         ///< rad; 0: none
};

/// Independent masses on the DoFs, pulled towards a target, under whatever map. All sizes n_q, but
/// max_effort n_a.
struct SimulatedLinearConfig {
  core::VecQ mass{};
  core::VecQ damping{};
  core::VecQ hand_stiffness{};
  core::VecQ hand_damping{};
  core::VecQ target{};
  core::VecA max_effort{};
};

/// A recording: time_s and the device's DoFs by name (a tracked palm's orientation also as a
/// quaternion), or joint angles through the inverse kinematics: time_s and each coordinate's name
/// with _rad, time_s,q_o1_mcp_rad,q_o2_pip_rad for a finger.
struct ReplayConfig {
  std::filesystem::path file{};
  bool repeat{false};
  core::VecA max_effort{};  ///< n_a
};

/// A board on a serial port that speaks the protocol of hw/README.md.
struct BoardConfig {
  std::string port{};    ///< "/dev/ttyACM0", a link under /dev/serial/by-id, or a pseudo-terminal
  int baud{921600};      ///< of real serial ports; USB ignores it
  std::string serial{};  ///< the board's own; empty: whichever answers
  core::VecA max_effort{};  ///< n_a, N or N m; the board's dictionary must allow at least this
  core::Duration max_silence{std::chrono::milliseconds(10)};
  core::Duration longest_lateness{0};  ///< loop_late_fault: the board's watchdog must be longer
  std::optional<board::Calibration> calibration{};  ///< absent: the sensors mean what they say
};

using DeviceConfig =
    std::variant<SimulatedFingerConfig, SimulatedLinearConfig, ReplayConfig, BoardConfig>;

/// Opens the device. Throws DeviceError: a file that cannot be read (path, line, column and what is
/// expected), a value that is not allowed, a kinematics the device does not go with.
[[nodiscard]] std::unique_ptr<Device> open_device(
    const DeviceConfig& config, std::shared_ptr<const core::Kinematics> kinematics);

}  // namespace haptic::hw
