#pragma once
/// A board's calibration, from the file that hapticctl calibrate wrote.

#include <filesystem>
#include <optional>
#include <string>

#include "haptic/core/model/kinematics.hpp"
#include "hw/board/calibration.hpp"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// Reads `file`; whatever is wrong is reported at `path`, the field that names it, and nothing comes
/// back. The DoFs stand in the order of `kinematics` (null: not known, sizes are not looked at). Whose
/// board it was made with is looked at when the board answers.
[[nodiscard]] std::optional<hw::board::Calibration> read_calibration(
    const std::filesystem::path& file, const std::string& path, const core::Kinematics* kinematics,
    Problems& problems);

}  // namespace haptic::server
