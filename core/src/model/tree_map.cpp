#include "tree_map.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptic/core/error.hpp"
#include "haptic/core/model/workspace.hpp"

namespace haptic::core {

TreeMap::TreeMap(RigidTree tree, std::vector<DofSpec> dofs, std::vector<TreeDrive> drives,
                 int rotation)
    : tree_(std::move(tree)),
      dofs_(std::move(dofs)),
      drives_(std::move(drives)),
      layout_(layout_of(dofs_)),
      space_(tree_.coordinates()),
      rotation_(rotation),
      mean_J_a_(core::mean_actuated_jacobian(*this)) {}

bool TreeMap::joints_of(const VecQ& q, double* y) const noexcept {
  if (q.size() != layout_.n_q() || !q.allFinite()) return false;
  std::copy(q.data(), q.data() + q.size(), y);
  VecX angles;
  MatXQ unused;
  for (const TreeDrive& drive : drives_) {
    const VecQ part = q.segment(drive.first, drive.mechanism->layout().n_q());
    if (drive.mechanism->evaluate(part, angles, unused) != MapStatus::kOk) return false;
    std::copy(angles.data(), angles.data() + angles.size(), y + drive.first);
  }
  return true;
}

bool TreeMap::through_mechanisms(const VecQ& q, MatXQ& J) const noexcept {
  VecX angles;
  MatXQ D;
  for (const TreeDrive& drive : drives_) {
    const int n = drive.mechanism->layout().n_q();
    if (drive.mechanism->evaluate(q.segment(drive.first, n), angles, D) != MapStatus::kOk) {
      return false;
    }
    for (int row = 0; row < J.rows(); ++row) {
      double product[kMaxQ];
      for (int c = 0; c < n; ++c) {
        product[c] = 0.0;
        for (int m = 0; m < n; ++m) product[c] += J(row, drive.first + m) * D(m, c);
      }
      for (int c = 0; c < n; ++c) J(row, drive.first + c) = product[c];
    }
  }
  return true;
}

MapStatus TreeMap::evaluate(const VecQ& q, VecX& x_probe, MatXQ& J) const noexcept {
  double y[kMaxQ];
  if (!joints_of(q, y)) return MapStatus::kCannotClose;
  tree_.evaluate(y, x_probe, J);
  return through_mechanisms(q, J) ? MapStatus::kOk : MapStatus::kCannotClose;
}

MapStatus TreeMap::second_order(const VecQ& q, int k, MatXQ& J_k) const noexcept {
  double y[kMaxQ];
  if (!joints_of(q, y)) return MapStatus::kCannotClose;
  const auto drive = std::find_if(drives_.begin(), drives_.end(), [k](const TreeDrive& d) {
    return k >= d.first && k < d.first + d.mechanism->layout().n_q();
  });
  if (drive == drives_.end()) {
    tree_.second_order(y, k, J_k);
    return through_mechanisms(q, J_k) ? MapStatus::kOk : MapStatus::kCannotClose;
  }
  // d(J_y D)/dq_k = (sum_m dJ_y/dy_m D_mk) D + J_y dD/dq_k, D = dy/dq of this mechanism.
  const Kinematics& mechanism = *drive->mechanism;
  const int n = mechanism.layout().n_q();
  const VecQ part = q.segment(drive->first, n);
  VecX angles, x;
  MatXQ D, dD, J_y, term;
  if (mechanism.evaluate(part, angles, D) != MapStatus::kOk ||
      mechanism.second_order(part, k - drive->first, dD) != MapStatus::kOk) {
    return MapStatus::kCannotClose;
  }
  J_k.setZero(tree_.n_x(), tree_.n_y());
  for (int m = 0; m < n; ++m) {
    tree_.second_order(y, drive->first + m, term);
    J_k += D(m, k - drive->first) * term;
  }
  if (!through_mechanisms(q, J_k)) return MapStatus::kCannotClose;
  tree_.evaluate(y, x, J_y);
  for (int c = 0; c < n; ++c) {
    for (int m = 0; m < n; ++m) J_k.col(drive->first + c) += dD(m, c) * J_y.col(drive->first + m);
  }
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
