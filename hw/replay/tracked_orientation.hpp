#pragma once
/// The orientation of a tracked palm in a recording. Trackers write quaternions, q holds a rotation
/// vector of at most pi; between rows the motion must run through a turn by pi, where that vector
/// jumps to the other side.

#include <optional>

#include "haptic/core/model/kinematics.hpp"
#include "hw/motion/motion_csv.hpp"
#include "hw/replay/stretch.hpp"

namespace haptic::hw {

/// Index in q of a tracked palm's rotation vector: the first of the DoFs NAME.rx .ry .rz.
[[nodiscard]] std::optional<std::size_t> rotation_vector_in(const std::vector<core::DofSpec>& dofs);

/// The DoFs' columns with NAME.qx .qy .qz .qw in place of NAME.rx .ry .rz at `at`.
[[nodiscard]] ColumnSet with_quaternion(ColumnSet dofs, std::size_t at);

/// Columns of with_quaternion() to those of the DoFs; a quaternion may have any length and sign.
/// Returns the first row whose quaternion is zero: it says nothing.
[[nodiscard]] std::optional<std::size_t> to_rotation_vectors(Columns& columns, std::size_t at);

/// The same in a table from `file`, whose DoF at `at` is called NAME.rx. Throws DeviceError naming
/// that row.
void from_quaternions(MotionTable& table, std::size_t at, const std::string& first_dof,
                      const std::filesystem::path& file);

/// The pose to which a row's rotation vector shall be near. kZero: the shortest vector, as a device
/// reports it. kPreviousRow: continuous from row to row (the first row stays near zero).
enum class Near { kZero, kPreviousRow };

/// Replaces the rotation vector of every row by the one of the same orientation near the reference.
void turn_near(Columns& q, const core::Kinematics& kinematics, Near near);

}  // namespace haptic::hw
