/// Where the tool and its points are, and how these move: the other half of bound_tool.cpp.

#include <algorithm>
#include <cmath>

#include "bound_tool.hpp"

namespace haptic::mujoco {

namespace {

constexpr double kShortest = 1e-3;  // of a quaternion

/// A point that a point or pose carries with it.
client::PointMap by_frame(const mjData& data, const Place& frame, const Vector3& position,
                          const std::vector<double>& x) {
  const std::size_t first = frame.binding.first_coordinate;
  if (frame.binding.kind == Binding::Kind::kPoint) {
    return {first, position, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}};
  }
  mjtNum back[4], q[4], offset[3];
  quaternion_of(data, frame, q);
  mju_negQuat(back, q);
  const Vector3 from = add(position, -1.0, position_of(data, frame));
  mju_rotVecQuat(offset, from.data(), back);
  return client::point_on_pose(x, vector_at(offset), first);
}

}  // namespace

void BoundTool::read(const mjData& data, std::vector<double>& x) const {
  for (const Place& place : places_) {
    const std::size_t first = place.binding.first_coordinate;
    if (place.binding.kind == Binding::Kind::kJoint) {
      const double here = data.qpos[model_->jnt_qposadr[place.id]] - place.binding.offset;
      x.at(first) += place.apart(x[first], here / place.binding.scale);
      continue;
    }
    const Vector3 position = position_of(data, place);
    std::copy(position.begin(), position.end(), x.begin() + static_cast<std::ptrdiff_t>(first));
    if (place.binding.kind == Binding::Kind::kPoint) continue;
    mjtNum q[4];
    quaternion_of(data, place, q);
    double* out = &x.at(first + 3);
    const double same = out[0] * q[1] + out[1] * q[2] + out[2] * q[3] + out[3] * q[0];
    for (int i = 0; i < 4; ++i) out[i] = (same < 0.0 ? -1.0 : 1.0) * q[(i + 1) % 4];
  }
}

bool BoundTool::has_turns(const std::vector<double>& x) const {
  return std::all_of(places_.begin(), places_.end(), [&x](const Place& place) {
    if (place.binding.kind != Binding::Kind::kPose) return true;
    const double* const q = &x.at(place.binding.first_coordinate + 3);
    const double length = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
    return length >= kShortest && std::isfinite(length);
  });
}

client::PointMap BoundTool::point_on(const mjData& data, int body, const Vector3& position,
                                     const std::vector<double>& x) const {
  const Path way = path(body);
  if (way.dofs.empty() && way.frame != nullptr) return by_frame(data, *way.frame, position, x);
  std::size_t low = coordinates_, high = 0;
  const auto span = [&](std::size_t first, std::size_t end) {
    low = std::min(low, first);
    high = std::max(high, end);
  };
  for (const int dof : way.dofs) {
    for (std::size_t c = 0; c < coordinates_; ++c) {
      if (coupled_.way(dof, c) != 0.0) span(c, c + 1);
    }
  }
  if (way.frame != nullptr) {
    const Binding& binding = way.frame->binding;
    span(binding.first_coordinate, binding.first_coordinate + count_of(binding.kind));
  }
  if (high == 0) low = 0;  // constraints let go of it since
  client::PointMap map{low, position, std::vector<Vector3>(high - low), {}};
  if (way.frame != nullptr) {
    const client::PointMap moved = by_frame(data, *way.frame, position, x);
    std::copy(moved.jacobian.begin(), moved.jacobian.end(),
              map.jacobian.begin() + static_cast<std::ptrdiff_t>(moved.first_coordinate - low));
  }
  const std::vector<mjtNum> J = jacobian(data, body, position);
  const auto column = [&](int dof) {
    const mjtNum* const at = J.data() + dof;
    return Vector3{at[0], at[model_->nv], at[2 * model_->nv]};
  };
  bool simple = way.frame == nullptr && high - low <= kMostCurved;
  for (const int dof : way.dofs) {
    simple = simple && model_->jnt_type[model_->dof_jntid[dof]] >= mjJNT_SLIDE;  // or a hinge
    for (std::size_t c = low; c < high; ++c) {
      map.jacobian[c - low] = add(map.jacobian[c - low], coupled_.way(dof, c), column(dof));
    }
  }
  if (!simple) return map;
  map.second.resize(triangle(high - low, 0));
  for (std::size_t k = 0; k < way.dofs.size(); ++k) {  // those from k on are nearer to the base
    for (std::size_t j = k; j < way.dofs.size(); ++j) {
      const int outer = way.dofs[k], inner = way.dofs[j], joint = model_->dof_jntid[inner];
      if (model_->jnt_type[joint] != mjJNT_HINGE) continue;
      const Vector3 bend = cross(vector_at(data.xaxis + 3 * joint), column(outer));
      for (std::size_t a = low; a < high; ++a) {
        for (std::size_t b = low; b <= a; ++b) {
          double share = coupled_.way(outer, a) * coupled_.way(inner, b);
          if (outer != inner) share += coupled_.way(inner, a) * coupled_.way(outer, b);
          Vector3& entry = map.second[triangle(a - low, b - low)];
          entry = add(entry, share, bend);
        }
      }
    }
  }
  return map;
}

std::vector<mjtNum> BoundTool::jacobian(const mjData& data, int body,
                                        const Vector3& position) const {
  std::vector<mjtNum> J(3 * static_cast<std::size_t>(model_->nv));
  mj_jac(model_, &data, J.data(), nullptr, position.data(), body);
  return J;
}

double BoundTool::give(const mjData& data, int body, const Vector3& position,
                       const Vector3& normal) const {
  const std::vector<mjtNum> J = jacobian(data, body, position);
  std::vector<mjtNum> along(static_cast<std::size_t>(model_->nv));
  for (int dof = 0; dof < model_->nv; ++dof) {
    const mjtNum* const at = J.data() + dof;
    if (!owns_dof(dof)) continue;
    along[static_cast<std::size_t>(dof)] =
        normal[0] * at[0] + normal[1] * at[model_->nv] + normal[2] * at[2 * model_->nv];
  }
  return coupled_.give(along);
}

}  // namespace haptic::mujoco
