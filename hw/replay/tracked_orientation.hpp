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

/// Every row as a device would report it: with the shortest rotation vector.
void fold(Columns& q, const core::Kinematics& kinematics);
/// Every row as the representative nearest to the row before.
void unfold(Columns& q, const core::Kinematics& kinematics);

}  // namespace haptic::hw
