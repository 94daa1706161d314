#include "hw/replay/tracked_orientation.hpp"

#include <string>

#include "haptic/core/error.hpp"
#include "haptic/core/model/rigid_pose.hpp"

namespace haptic::hw {
std::optional<std::size_t> rotation_vector_in(const std::vector<core::DofSpec>& dofs) {
  for (std::size_t i = 0; i + 2 < dofs.size(); ++i) {
    if (dofs[i].name.ends_with(".rx") && dofs[i + 1].name.ends_with(".ry") &&
        dofs[i + 2].name.ends_with(".rz")) {
      return i;
    }
  }
  return std::nullopt;
}

ColumnSet with_quaternion(ColumnSet dofs, std::size_t at) {
  const std::string stem = dofs[at].substr(0, dofs[at].size() - 2);  // "palm."
  const auto begin = dofs.begin() + static_cast<std::ptrdiff_t>(at);
  dofs.erase(begin, begin + 3);
  const ColumnSet parts{stem + "qx", stem + "qy", stem + "qz", stem + "qw"};
  dofs.insert(dofs.begin() + static_cast<std::ptrdiff_t>(at), parts.begin(), parts.end());
  return dofs;
}

std::optional<std::size_t> to_rotation_vectors(Columns& columns, std::size_t at) {
  for (std::size_t row = 0; row < columns[at].size(); ++row) {
    const core::UnitQuaternion q{columns[at][row], columns[at + 1][row], columns[at + 2][row],
                                 columns[at + 3][row]};
    if (q.x == 0.0 && q.y == 0.0 && q.z == 0.0 && q.w == 0.0) return row;
    const Eigen::Vector3d phi = core::rotation_vector(q);
    for (std::size_t i = 0; i < 3; ++i) columns[at + i][row] = phi[static_cast<Eigen::Index>(i)];
  }
  columns.erase(columns.begin() + static_cast<std::ptrdiff_t>(at) + 3);
  return std::nullopt;
}

void from_quaternions(MotionTable& table, std::size_t at, const std::string& first_dof,
                      const std::filesystem::path& file) {
  const std::optional<std::size_t> zero = to_rotation_vectors(table.values, at);
  if (!zero) return;
  throw core::DeviceError(file.string() + ":" + std::to_string(table.line[*zero]) + ": columns " +
                          first_dof.substr(0, first_dof.size() - 2) +
                          "qx .qy .qz .qw = 0, 0, 0, 0: must be a quaternion other than zero");
}

void turn_near(Columns& q, const core::Kinematics& kinematics, Near near) {
  core::VecQ reference = core::VecQ::Zero(static_cast<Eigen::Index>(q.size()));
  core::VecQ values = reference;
  for (std::size_t row = 0; row < q.front().size(); ++row) {
    for (std::size_t c = 0; c < q.size(); ++c) values[static_cast<Eigen::Index>(c)] = q[c][row];
    kinematics.nearest_representative(reference, values);
    for (std::size_t c = 0; c < q.size(); ++c) q[c][row] = values[static_cast<Eigen::Index>(c)];
    if (near == Near::kPreviousRow) reference = values;
  }
}

}  // namespace haptic::hw
