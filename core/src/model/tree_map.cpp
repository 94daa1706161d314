#include "tree_map.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptic/core/error.hpp"

namespace haptic::core {

TreeMap::TreeMap(RigidTree tree, std::vector<DofSpec> dofs, std::vector<TreeDrive> drives,
                 int rotation)
    : Kinematics(std::move(dofs), ConfigurationSpace(tree.coordinates())),
      tree_(std::move(tree)),
      drives_(std::move(drives)),
      rotation_(rotation) {
  mean_J_a_ = core::mean_actuated_jacobian(*this);
  for (const TreeDrive& drive : drives_) {
    mechanisms_.push_back({drive.mechanism.get(), drive.first});
  }
}

struct TreeMap::Joints {
  double y[kMaxQ];
  Eigen::Matrix2d D[kMaxQ / 2];  // dy/dq of each drive
};

bool TreeMap::joints_of(const VecQ& q, Joints& joints) const noexcept {
  if (q.size() != layout_.n_q() || !q.allFinite()) return false;
  std::copy(q.data(), q.data() + q.size(), joints.y);
  VecX y;
  MatXQ D;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    const VecQ part = q.segment<2>(drives_[i].first);
    if (drives_[i].mechanism->evaluate(part, y, D) != MapStatus::kOk) return false;
    std::copy(y.data(), y.data() + 2, joints.y + drives_[i].first);
    joints.D[i] = D;
  }
  return true;
}

void TreeMap::through_mechanisms(const Joints& joints, MatXQ& J) const noexcept {
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    const Eigen::Matrix2d& D = joints.D[i];
    double* first = J.data() + drives_[i].first * J.rows();
    double* second = first + J.rows();
    for (Eigen::Index row = 0; row < J.rows(); ++row) {
      const double a = first[row], b = second[row];
      first[row] = a * D(0, 0) + b * D(1, 0);
      second[row] = a * D(0, 1) + b * D(1, 1);
    }
  }
}

MapStatus TreeMap::evaluate(const VecQ& q, VecX& x_probe, MatXQ& J) const noexcept {
  Joints joints;
  if (!joints_of(q, joints)) return MapStatus::kCannotClose;
  tree_.evaluate(joints.y, x_probe, J);
  through_mechanisms(joints, J);
  return MapStatus::kOk;
}

void TreeMap::nearest_representative(const VecQ& near, VecQ& q) const noexcept {
  if (rotation_ < 0) return;
  q.segment<3>(rotation_) =
      nearest_rotation_vector(q.segment<3>(rotation_), near.segment<3>(rotation_));
}

void append_palm(const TrackedPalm& palm, std::vector<DofSpec>& dofs) {
  if (!(std::isfinite(palm.position_lower) && std::isfinite(palm.position_upper) &&
        palm.position_lower < palm.position_upper)) {
    throw SceneError(palm.name + ".position from " + std::to_string(palm.position_lower) + " to " +
                     std::to_string(palm.position_upper) +
                     " m: both must be finite, lower < upper");
  }
  if (palm.name.empty()) throw SceneError("palm.name is empty: must be given");
  for (const char* axis : {".x", ".y", ".z"}) {
    dofs.push_back(
        {palm.name + axis, Unit::kMetre, false, palm.position_lower, palm.position_upper});
  }
  for (const char* axis : {".rx", ".ry", ".rz"}) {
    dofs.push_back(
        {palm.name + axis, Unit::kRadian, false, -1.5 * std::numbers::pi, 1.5 * std::numbers::pi});
  }
}

void require_new_name(const std::string& name, const std::vector<DofSpec>& dofs) {
  if (name.empty()) throw SceneError("a joint's name is empty: must be given");
  if (name == "base") throw SceneError("joint base: the name is taken by the fixed frame");
  for (const DofSpec& dof : dofs) {
    if (dof.name == name) throw SceneError("joint " + name + " given twice: names must differ");
  }
}

void require_new_output(const std::string& name, const Pose3& offset,
                        const std::vector<TreeOutput>& others) {
  const std::string where = "output " + name;
  if (name.empty()) throw SceneError("an output's name is empty: must be given");
  for (const TreeOutput& other : others) {
    if (other.name == name) throw SceneError(where + " given twice: names must differ");
  }
  require_pose(offset, where + ".offset");
}

void require_pose(const Pose3& pose, const std::string& where) {
  const Point3& p = pose.position;
  if (!(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z))) {
    throw SceneError(where + ".position: must be finite");
  }
  const UnitQuaternion& q = pose.orientation;
  const double norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  if (!(std::isfinite(norm) && norm > 1e-6)) {
    throw SceneError(where + ".orientation of norm " + std::to_string(norm) +
                     ": must be a quaternion other than zero");
  }
}

}  // namespace haptic::core
