#include "hw/replay/tracked_orientation.hpp"

#include <string>

#include "haptic/core/model/rigid_pose.hpp"

namespace haptic::hw {
namespace {

core::VecQ row_of(const Columns& q, std::size_t row) {
  core::VecQ values(static_cast<Eigen::Index>(q.size()));
  for (std::size_t c = 0; c < q.size(); ++c) values[static_cast<Eigen::Index>(c)] = q[c][row];
  return values;
}

void set_row(Columns& q, std::size_t row, const core::VecQ& values) {
  for (std::size_t c = 0; c < q.size(); ++c) q[c][row] = values[static_cast<Eigen::Index>(c)];
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

}  // namespace

std::optional<std::size_t> rotation_vector_in(const std::vector<core::DofSpec>& dofs) {
  for (std::size_t i = 0; i + 2 < dofs.size(); ++i) {
    if (ends_with(dofs[i].name, ".rx") && ends_with(dofs[i + 1].name, ".ry") &&
        ends_with(dofs[i + 2].name, ".rz")) {
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

void fold(Columns& q, const core::Kinematics& kinematics) {
  const core::VecQ home = core::VecQ::Zero(static_cast<Eigen::Index>(q.size()));
  for (std::size_t row = 0; row < q.front().size(); ++row) {
    core::VecQ values = row_of(q, row);
    kinematics.nearest_representative(home, values);
    set_row(q, row, values);
  }
}

void unfold(Columns& q, const core::Kinematics& kinematics) {
  for (std::size_t row = 1; row < q.front().size(); ++row) {
    core::VecQ values = row_of(q, row);
    kinematics.nearest_representative(row_of(q, row - 1), values);
    set_row(q, row, values);
  }
}

}  // namespace haptic::hw
