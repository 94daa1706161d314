#include "bound_tool.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

namespace haptic::mujoco {

namespace {

constexpr std::size_t kMostCoordinates = 10000;  // far above those of any device
constexpr double kFollows = 10.0;                // stiffness of a follower, per the coupling's
constexpr mjtNum kBeyond = 1e9;                  // m, longer than any tendon

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

BoundTool::BoundTool(mjModel& model, mjData& data, const std::vector<Binding>& bindings,
                     const ToolOptions& options)
    : model_(&model),
      frame_of_body_(static_cast<std::size_t>(model.nbody), -1),
      pulls_(static_cast<std::size_t>(model.nv), 0),
      coupled_(model) {
  if (!(options.coupling > 0.0)) {
    throw std::invalid_argument("coupling " + std::to_string(options.coupling) +
                                ": must be above 0 (N/m, or N m/rad)");
  }
  for (const Binding& binding : bindings) find(data, binding);
  std::vector<char> taken(coordinates_, 0);
  const auto weight = [&options](std::size_t i) {
    return options.weights.empty() ? 1.0 : options.weights[i];
  };
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
      if (!(weight(i) > 0.0)) {
        refuse(place.binding, "the weight of coordinate " + std::to_string(i) +
                                  " must be above 0, not " + std::to_string(weight(i)));
      }
    }
    refuse_stiff(place, options);
  }
  for (const Place& one : followers_) {
    follow(model, one, options.coupling * weight(one.binding.first_coordinate));
  }
  for (const Place& place : places_) {
    if (place.binding.kind == Binding::Kind::kJoint) continue;
    for (int body = place.body; body > 0; body = model.body_parentid[body]) {
      for (int k = 0; k < model.body_dofnum[body]; ++k) {
        const int dof = model.body_dofadr[body] + k;
        pulls_[static_cast<std::size_t>(dof)] = 1;
        if (!coupled_.bound(dof)) coupled_.leave_out(dof);
      }
    }
  }
  // Tendons make rows if they are beyond their limits.
  std::vector<mjtNum> ranges(model.tendon_range, model.tendon_range + 2 * model.ntendon);
  std::fill_n(model.tendon_range, 2 * model.ntendon, kBeyond);
  mj_fwdPosition(&model, &data);
  std::copy(ranges.begin(), ranges.end(), model.tendon_range);
  coupled_.look(model, data, coordinates_, true);
  find_moved();
}

void BoundTool::follow(mjModel& model, const Place& place, double spring) {
  const std::size_t c = place.binding.first_coordinate;
  const auto leader = std::find_if(places_.begin(), places_.end(), [c](const Place& other) {
    return other.binding.first_coordinate == c;
  });
  const double step = model.opt.timestep, scale = place.binding.scale;
  // The spring is as stiff as both masses allow in a step. A light joint gets armature.
  const double stiffness = std::min(kFollows * spring, 0.1 * leader->mass / (step * step));
  const double mass = std::max(place.mass, 4.0 * step * step * stiffness);
  model.dof_armature[place.dofs[0]] += (mass - place.mass) / (scale * scale);
  const double together = 1.0 / (1.0 / mass + 1.0 / leader->mass);
  const double ratio = scale / leader->binding.scale;
  coupled_.follow({.joint = place.id,
                   .dof = place.dofs[0],
                   .leader = leader->dofs[0],
                   .leader_qpos = model.jnt_qposadr[leader->id],
                   .ratio = ratio,
                   .offset = place.binding.offset - ratio * leader->binding.offset,
                   .stiffness = stiffness / (scale * scale),
                   .damping = 2.0 * std::sqrt(stiffness * together) / (scale * scale)});
  leader->mass += mass;
}

void BoundTool::look(const mjData& data) {
  coupled_.look(*model_, data, coordinates_);
  find_moved();
}

void BoundTool::find_moved() {
  const mjModel& m = *model_;
  const auto bodies = static_cast<std::size_t>(m.nbody);
  std::vector<char> firm(bodies, 1),
      carried(bodies, 0);  // with all that is between it and the base
  moves_.assign(bodies, 0);
  owns_.assign(static_cast<std::size_t>(m.nv), 0);
  for (std::size_t body = 1; body < bodies; ++body) {
    const auto parent = static_cast<std::size_t>(m.body_parentid[body]);
    bool below = moves_[parent] != 0 || frame_of_body_[body] >= 0;
    firm[body] = firm[parent];
    carried[body] = carried[parent];
    const int first = m.body_dofadr[body], end = first + m.body_dofnum[body];
    for (int dof = first; dof < end; ++dof) {
      below = below || coupled_.bound(dof);
      if (!coupled_.firm(dof)) firm[body] = 0;
      if (!coupled_.moves(dof)) continue;
      carried[body] = pulls_[static_cast<std::size_t>(dof)] = 1;
    }
    moves_[body] = below || (firm[body] != 0 && carried[body] != 0) ? 1 : 0;
    for (int dof = first; dof < end && moves_[body] != 0; ++dof) {
      owns_[static_cast<std::size_t>(dof)] = pulls_[static_cast<std::size_t>(dof)] = 1;
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
  if (binding.first_coordinate > kMostCoordinates - count_of(binding.kind)) {
    refuse(binding, "coordinate " + std::to_string(binding.first_coordinate) +
                        ": a device has at most " + std::to_string(kMostCoordinates));
  }
  coordinates_ = std::max(coordinates_, binding.first_coordinate + count_of(binding.kind));
  Place place;
  place.binding = binding;
  const bool joint = binding.kind == Binding::Kind::kJoint;
  if (joint) {
    find_joint(place);
  } else {
    find_frame(data, place);
  }
  const bool second =
      joint && std::any_of(places_.begin(), places_.end(), [&binding](const Place& other) {
        return other.binding.kind == Binding::Kind::kJoint &&
               other.binding.first_coordinate == binding.first_coordinate;
      });
  (second ? followers_ : places_).push_back(place);
}

void BoundTool::find_joint(Place& place) {
  const mjModel& m = *model_;
  const Binding& binding = place.binding;
  place.id = mj_name2id(&m, mjOBJ_JOINT, binding.name.c_str());
  if (place.id < 0) refuse(binding, "the model has no joint of this name");
  if (m.jnt_type[place.id] != mjJNT_HINGE && m.jnt_type[place.id] != mjJNT_SLIDE) {
    refuse(binding, "must be a hinge or a slide; bind the body of a free or ball joint by pose()");
  }
  if (!(binding.scale != 0.0) || !std::isfinite(binding.scale)) {
    refuse(binding, "scale must not be 0, and finite");
  }
  const int dof = m.jnt_dofadr[place.id];
  if (coupled_.bound(dof)) refuse(binding, "the joint is bound twice");
  coupled_.bind(dof, binding.first_coordinate, binding.scale);
  place.body = m.jnt_bodyid[place.id];
  place.dofs = {dof};
  place.turns = m.jnt_type[place.id] == mjJNT_HINGE;
  place.mass = binding.scale * binding.scale / m.dof_invweight0[dof];
}

void BoundTool::find_frame(mjData& data, Place& place) {
  const mjModel& m = *model_;
  const Binding& binding = place.binding;
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

BoundTool::Path BoundTool::path(int body) const {
  Path found;
  for (; body > 0; body = model_->body_parentid[body]) {
    if (const int frame = frame_of_body_[static_cast<std::size_t>(body)]; frame >= 0) {
      found.frame = &places_[static_cast<std::size_t>(frame)];
      break;
    }
    const int first = model_->body_dofadr[body];
    for (int dof = first + model_->body_dofnum[body] - 1; dof >= first; --dof) {
      if (coupled_.moves(dof)) found.dofs.push_back(dof);
    }
  }
  return found;
}

}  // namespace haptic::mujoco
