#pragma once
/// Corrections of a board's sensor readings. `hapticctl calibrate` measures them once per device
/// and stores them with the device's serial number; another device must not use them.

#include <string>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "haptic/core/tick/tick_input.hpp"
#include "haptic/core/types.hpp"

namespace haptic::hw::board {

/// q = scale reading + offset;  force = reading - force_zero. Sizes n_q, but force_zero n_a or 0.
struct Calibration {
  std::string source{};          ///< the file it was read from, for messages
  std::string serial{};          ///< of the device it was made with
  std::string date{};            ///< when, as in "2026-11-21"
  core::VecQ scale{}, offset{};  ///< 1, m or rad
  core::VecQ lower{}, upper{};   ///< travel, m or rad; within the DoF's range
  core::VecA force_zero{};       ///< N or N m; size 0: the device measures none
};

/// Throws DeviceError: made with a device of another serial number, sizes that do not fit, a value
/// that is not allowed, a travel that is not within the DoF's range.
void check(const Calibration& calibration, const core::Kinematics& kinematics,
           const std::string& serial, bool measures_force);

/// Corrects a sample. Sizes as check() allows. Never allocates.
void apply(const Calibration& calibration, core::DeviceSample& sample) noexcept;

/// Sets the range of a valid sample to the travel plus the margin of device_limits() (5 %).
void apply(const Calibration& calibration, core::DeviceLimits& limits) noexcept;

/// The sensor readings at which the device is at `position` (n_a): what a servo on the board must
/// be sent.
[[nodiscard]] core::VecA to_readings(const Calibration& calibration, const core::DofLayout& layout,
                                     const core::VecA& position) noexcept;

/// The load-cell readings at which the device holds `tau_a` (n_a): what a force loop on the board
/// must be sent.
[[nodiscard]] core::VecA to_force_readings(const Calibration& calibration,
                                           const core::VecA& tau_a) noexcept;

}  // namespace haptic::hw::board
