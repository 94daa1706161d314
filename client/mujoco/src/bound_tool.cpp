#include "bound_tool.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

namespace haptic::mujoco {

namespace {

constexpr double kShortest = 1e-3;               // of a quaternion
constexpr std::size_t kMostCoordinates = 10000;  // far above those of any device

[[noreturn]] void refuse(const Binding& binding, const std::string& why) {
  throw std::invalid_argument("binding '" + binding.name + "': " + why);
}

/// Inverse masses of the lightest direction of a site or body, 1/kg, and about its lightest axis,
/// 1/(kg m^2): no less than the largest eigenvalues of J M^-1 J^T.
std::pair<double, double> inverse_masses(const mjModel& model, mjData& data, const Place& place) {
  const auto nv = static_cast<std::size_t>(model.nv);
  std::vector<mjtNum> J(6 * nv), solved(6 * nv);
  const Vector3 position = position_of(data, place);
  mj_jac(&model, &data, J.data(), J.data() + 3 * nv, position.data(), place.body);
  mj_solveM(&model, &data, solved.data(), J.data(), 6);
  double most[2] = {0.0, 0.0};
  for (std::size_t i = 0; i < 6; ++i) {
    double sum = 0.0;
    for (std::size_t k = i / 3 * 3; k < i / 3 * 3 + 3; ++k) {
      sum += std::abs(mju_dot(J.data() + i * nv, solved.data() + k * nv, model.nv));
    }
    most[i / 3] = std::max(most[i / 3], sum);
  }
  return {most[0], most[1]};
}

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

std::size_t count_of(Binding::Kind kind) noexcept {
  return kind == Binding::Kind::kJoint ? 1 : kind == Binding::Kind::kPoint ? 3 : 7;
}

Vector3 position_of(const mjData& data, const Place& place) {
  return vector_at((place.site ? data.site_xpos : data.xpos) + 3 * place.id);
}

void quaternion_of(const mjData& data, const Place& place, mjtNum quaternion[4]) {
  mju_mat2Quat(quaternion, (place.site ? data.site_xmat : data.xmat) + 9 * place.id);
}

double Place::apart(double a, double b) const {
  constexpr double kPi = std::numbers::pi;
  return turns && std::abs(b - a) > kPi ? std::remainder(b - a, 2.0 * kPi) : b - a;
}

BoundTool::BoundTool(const mjModel& model, mjData& data, const std::vector<Binding>& bindings,
                     const ToolOptions& options)
    : model_(&model),
      place_of_joint_(static_cast<std::size_t>(model.njnt), -1),
      frame_of_body_(static_cast<std::size_t>(model.nbody), -1),
      moves_(static_cast<std::size_t>(model.nbody), 0),
      owns_(static_cast<std::size_t>(model.nv), 0) {
  if (!(options.coupling > 0.0)) {
    throw std::invalid_argument("coupling " + std::to_string(options.coupling) +
                                ": must be above 0 (N/m, or N m/rad)");
  }
  for (const Binding& binding : bindings) find(data, binding);
  std::vector<char> taken(coordinates_, 0);
  for (const Place& place : places_) {
    const std::size_t first = place.binding.first_coordinate;
    for (std::size_t i = first; i < first + count_of(place.binding.kind); ++i) {
      if (taken[i]++ != 0) {
        refuse(place.binding, "coordinate " + std::to_string(i) + " is bound twice");
      }
      if (!options.weights.empty() && i >= options.weights.size()) {
        refuse(place.binding, "coordinate " + std::to_string(i) + " has no weight: there are " +
                                  std::to_string(options.weights.size()));
      }
      const double weight = options.weights.empty() ? 1.0 : options.weights[i];
      if (!(weight > 0.0)) {
        refuse(place.binding, "the weight of coordinate " + std::to_string(i) +
                                  " must be above 0, not " + std::to_string(weight));
      }
    }
    refuse_stiff(place, options);
  }
  for (int body = 0; body < model.nbody; ++body) {
    const Path way = path(body);
    moves_[static_cast<std::size_t>(body)] = way.frame != nullptr || !way.joints.empty();
    if (!moves(body)) continue;
    const int first = model.body_dofadr[body];
    for (int k = 0; k < model.body_dofnum[body]; ++k)
      owns_[static_cast<std::size_t>(first + k)] = 1;
  }
  pulls_ = owns_;
  for (const Place& place : places_) {
    if (place.binding.kind == Binding::Kind::kJoint) continue;
    for (int body = place.body; body > 0; body = model.body_parentid[body]) {
      const int first = model.body_dofadr[body];
      for (int k = 0; k < model.body_dofnum[body]; ++k)
        pulls_[static_cast<std::size_t>(first + k)] = 1;
    }
  }
}

void BoundTool::refuse_stiff(const Place& place, const ToolOptions& options) const {
  const std::size_t first = place.binding.first_coordinate;
  for (std::size_t i = first; i < first + count_of(place.binding.kind); ++i) {
    const bool turn = place.binding.kind == Binding::Kind::kPose && i >= first + 3;
    const double weight = options.weights.empty() ? 1.0 : options.weights[i];
    const double stiffness = options.coupling * weight * (turn ? 0.25 : 1.0);
    const double mass = turn ? place.inertia : place.mass, step = model_->opt.timestep;
    if (step * std::sqrt(stiffness / mass) <= 0.5) continue;
    char text[300];
    std::snprintf(text, sizeof text,
                  "the coupling is too stiff for the model's step: coordinate %zu has a mass of "
                  "%.3g kg (kg m^2) and needs at least %.3g; give it mass or armature, shorten the "
                  "timestep, or lower the coupling or its weight",
                  i, mass, 4.0 * step * step * stiffness);
    refuse(place.binding, text);
  }
}

void BoundTool::find(mjData& data, const Binding& binding) {
  const mjModel& m = *model_;
  if (binding.first_coordinate > kMostCoordinates - count_of(binding.kind)) {
    refuse(binding, "coordinate " + std::to_string(binding.first_coordinate) +
                        ": a device has at most " + std::to_string(kMostCoordinates));
  }
  Place place;
  place.binding = binding;
  if (binding.kind == Binding::Kind::kJoint) {
    place.id = mj_name2id(&m, mjOBJ_JOINT, binding.name.c_str());
    if (place.id < 0) refuse(binding, "the model has no joint of this name");
    if (m.jnt_type[place.id] != mjJNT_HINGE && m.jnt_type[place.id] != mjJNT_SLIDE) {
      refuse(binding,
             "must be a hinge or a slide; bind the body of a free or ball joint by pose()");
    }
    if (!(binding.scale != 0.0) || !std::isfinite(binding.scale)) {
      refuse(binding, "scale must not be 0, and finite");
    }
    const int dof = m.jnt_dofadr[place.id];
    place.body = m.jnt_bodyid[place.id];
    place.dofs = {dof};
    place.turns = m.jnt_type[place.id] == mjJNT_HINGE;
    place.mass = binding.scale * binding.scale / m.dof_invweight0[dof];
    place_of_joint_[static_cast<std::size_t>(place.id)] = static_cast<int>(places_.size());
  } else {
    place.id = mj_name2id(&m, mjOBJ_SITE, binding.name.c_str());
    place.site = place.id >= 0;
    if (!place.site) place.id = mj_name2id(&m, mjOBJ_BODY, binding.name.c_str());
    if (place.id < 0) refuse(binding, "the model has no site and no body of this name");
    place.body = place.site ? m.site_bodyid[place.id] : place.id;
    int& frame = frame_of_body_[static_cast<std::size_t>(place.body)];
    if (frame >= 0) refuse(binding, "its body has two points or poses; one of them must do");
    frame = static_cast<int>(places_.size());
    for (int k = 0; k < m.body_dofnum[place.body]; ++k) {
      place.dofs.push_back(m.body_dofadr[place.body] + k);
    }
    const std::pair<double, double> inverse = inverse_masses(m, data, place);
    if (!(inverse.first > 0.0)) refuse(binding, "its body cannot move: it has no joint");
    place.mass = 1.0 / inverse.first;
    place.inertia = 1.0 / std::max<double>(inverse.second, mjMINVAL);
  }
  coordinates_ = std::max(coordinates_, binding.first_coordinate + count_of(binding.kind));
  places_.push_back(place);
}

BoundTool::Path BoundTool::path(int body) const {
  Path found;
  std::vector<int> pending;
  const auto reached = [&] {  // the springs so far are between a binding and the body
    found.soft.insert(found.soft.end(), pending.begin(), pending.end());
    pending.clear();
  };
  for (; body > 0; body = model_->body_parentid[body]) {
    if (const int frame = frame_of_body_[static_cast<std::size_t>(body)]; frame >= 0) {
      reached();
      found.frame = &places_[static_cast<std::size_t>(frame)];
      break;
    }
    for (int k = model_->body_jntnum[body] - 1; k >= 0; --k) {
      const int joint = model_->body_jntadr[body] + k;
      if (const int bound = place_of_joint_[static_cast<std::size_t>(joint)]; bound >= 0) {
        reached();
        found.joints.push_back(&places_[static_cast<std::size_t>(bound)]);
      } else if (model_->jnt_stiffness[joint] > 0.0) {
        pending.push_back(joint);
      }
    }
  }
  return found;
}

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
  if (way.joints.empty() && way.frame != nullptr) return by_frame(data, *way.frame, position, x);
  std::size_t low = coordinates_, high = 0;
  const auto span = [&](const Place& place) {
    low = std::min(low, place.binding.first_coordinate);
    high = std::max(high, place.binding.first_coordinate + count_of(place.binding.kind));
  };
  for (const Place* joint : way.joints) span(*joint);
  if (way.frame != nullptr) span(*way.frame);
  client::PointMap map{low, position, std::vector<Vector3>(high - low), {}};
  if (way.frame != nullptr) {
    const client::PointMap moved = by_frame(data, *way.frame, position, x);
    std::copy(moved.jacobian.begin(), moved.jacobian.end(),
              map.jacobian.begin() + static_cast<std::ptrdiff_t>(moved.first_coordinate - low));
  }
  const auto axis = [&](const Place& joint) {
    return add({}, joint.binding.scale, vector_at(data.xaxis + 3 * joint.id));
  };
  for (const Place* joint : way.joints) {
    const Vector3 arm = add(position, -1.0, vector_at(data.xanchor + 3 * joint->id));
    map.jacobian[joint->binding.first_coordinate - low] =
        joint->turns ? cross(axis(*joint), arm) : axis(*joint);
  }
  if (way.frame != nullptr || high - low > kMostCurved) return map;
  map.second.resize(triangle(high - low, 0));
  for (std::size_t k = 0; k < way.joints.size(); ++k) {  // joints from k on are nearer to the base
    const std::size_t outer = way.joints[k]->binding.first_coordinate - low;
    for (std::size_t j = k; j < way.joints.size(); ++j) {
      if (!way.joints[j]->turns) continue;
      map.second[triangle(outer, way.joints[j]->binding.first_coordinate - low)] =
          cross(axis(*way.joints[j]), map.jacobian[outer]);
    }
  }
  return map;
}

double BoundTool::give(const mjData& data, int body, const Vector3& position,
                       const Vector3& normal) const {
  const Path way = path(body);
  if (way.soft.empty()) return 0.0;
  std::vector<mjtNum> jacobian(3 * static_cast<std::size_t>(model_->nv));
  mj_jac(model_, &data, jacobian.data(), nullptr, position.data(), body);
  double sum = 0.0;
  for (const int joint : way.soft) {
    const int type = model_->jnt_type[joint];
    const int dofs = type == mjJNT_FREE ? 6 : type == mjJNT_BALL ? 3 : 1;
    for (int k = 0; k < dofs; ++k) {
      const mjtNum* column = jacobian.data() + model_->jnt_dofadr[joint] + k;
      const double along = normal[0] * column[0] + normal[1] * column[model_->nv] +
                           normal[2] * column[2 * model_->nv];
      sum += along * along / model_->jnt_stiffness[joint];
    }
  }
  return sum;
}

}  // namespace haptic::mujoco
