#include "pushed_object.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace haptic::mujoco {

namespace {

constexpr double kHold = 0.05;           // s, h
constexpr double kHeaviest = 1e6;        // kg; beyond, it is a wall
constexpr std::size_t kMostMotions = 6;  // of Plane::object_direction
constexpr double kNewMotion = 1e-6;      // square of the part of a direction that is a new one

bool is_contact(int type) {
  return type == mjCNSTR_CONTACT_FRICTIONLESS || type == mjCNSTR_CONTACT_PYRAMIDAL ||
         type == mjCNSTR_CONTACT_ELLIPTIC;
}

double along(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Directions with these cosines between them, by Cholesky's rule: each is a sum of those that came
/// before it, and of a new one if there is room.
void find_directions(const std::vector<PushedObject*>& together) {
  std::vector<const PushedObject*> news;
  for (PushedObject* object : together) {
    std::vector<double>& e = object->direction;
    double left = 1.0;
    for (const PushedObject* base : news) {
      const double cosine = object->give * along(object->motion, base->recedes) /
                            std::sqrt(object->give * base->give);
      const double told = std::inner_product(e.begin(), e.end(), base->direction.begin(), 0.0);
      e.push_back((cosine - told) / base->direction.back());
      left -= e.back() * e.back();
    }
    if (left > kNewMotion && news.size() < kMostMotions) {
      e.push_back(std::sqrt(left));
      news.push_back(object);
    }
    const double length = std::sqrt(along(e, e));
    for (double& part : e) part /= length;
  }
}

}  // namespace

void Surroundings::look(const mjModel& model, mjData& data, const std::vector<mjtNum>& rate) {
  const auto nv = static_cast<std::size_t>(model.nv);
  rate_ = rate;
  dofs_.clear();
  for (std::size_t i = 0; i < nv; ++i) {
    if (!tool_->owns_dof(static_cast<int>(i))) dofs_.push_back(i);
  }
  const std::size_t n = dofs_.size();
  if (n == 0) return;
  look_at_rows(model, data, rate);
  M_.assign(n * n, 0.0);
  push_.assign(n, 0.0);
  std::vector<mjtNum> unit(nv), column(nv);
  for (std::size_t k = 0; k < n; ++k) {
    std::fill(unit.begin(), unit.end(), 0.0);
    unit[dofs_[k]] = 1.0;
    mj_mulM(&model, &data, column.data(), unit.data());
    for (std::size_t i = 0; i < n; ++i) M_[i * n + k] = column[dofs_[i]];
    push_[k] = data.qfrc_smooth[dofs_[k]] + data.qfrc_constraint[dofs_[k]] +
               model.dof_damping[dofs_[k]] * rate[dofs_[k]];
  }
  H_ = M_;
  for (std::size_t k = 0; k < n; ++k) {
    H_[k * n + k] += kHold * model.dof_damping[dofs_[k]] +
                     kHold * kHold * model.jnt_stiffness[model.dof_jntid[dofs_[k]]];
  }
  for (const Row& row : rows_) {
    const double weight = row.mass + kHold * row.damping + kHold * kHold * row.stiffness;
    for (std::size_t i = 0; i < n; ++i) {
      push_[i] += row.way[i] * row.taken;
      for (std::size_t k = 0; k < n; ++k) H_[i * n + k] += weight * row.way[i] * row.way[k];
    }
  }
  mju_cholFactor(H_.data(), static_cast<int>(n), mjMINVAL);
}

void Surroundings::look_at_rows(const mjModel& model, mjData& data,
                                const std::vector<mjtNum>& rate) {
  rows_.clear();
  const auto nv = static_cast<std::size_t>(model.nv);
  std::vector<mjtNum> unit(static_cast<std::size_t>(std::max(data.nefc, 1))), way(nv);
  const auto row_of = [&](int index) {
    std::fill(unit.begin(), unit.end(), 0.0);
    unit[static_cast<std::size_t>(index)] = 1.0;
    mj_mulJacTVec(&model, &data, way.data(), unit.data());
    Row row;
    for (const std::size_t dof : dofs_) row.way.push_back(way[dof]);
    return row;
  };
  for (int i = 0; i < data.nefc; ++i) {
    const int type = data.efc_type[i], state = data.efc_state[i];
    if (state != mjCNSTRSTATE_QUADRATIC && state != mjCNSTRSTATE_CONE) continue;
    const mjContact* contact = is_contact(type) ? data.contact + data.efc_id[i] : nullptr;
    const auto of_tool = [&](int geom) {
      return geom >= 0 && tool_->moves(model.geom_bodyid[geom]);
    };
    if (contact != nullptr && (of_tool(contact->geom1) || of_tool(contact->geom2))) continue;
    const int place = contact != nullptr ? i - contact->efc_address : 0;
    if (state == mjCNSTRSTATE_CONE && place > 0) continue;  // it slips
    Row row = row_of(i);
    const mjtNum *KBI = data.efc_KBIP + 4 * i, inverse = 1.0 / data.efc_R[i];
    row.mass = inverse;
    row.damping = KBI[1] * inverse;
    for (std::size_t k = 0; k < dofs_.size(); ++k) {
      row.taken += row.way[k] * (row.damping * rate[dofs_[k]] + row.mass * data.qacc[dofs_[k]]);
    }
    const double stiffness = KBI[0] * KBI[2] * inverse;
    if (type ==
        mjCNSTR_CONTACT_PYRAMIDAL) {  // two edges lie about the normal, which has the spring
      const Row other = row_of(place % 2 == 0 ? i + 1 : i - 1);
      Row normal{row.way, 0.0, 0.0, stiffness, 0.0};
      for (std::size_t k = 0; k < dofs_.size(); ++k) {
        normal.way[k] = 0.5 * (row.way[k] + other.way[k]);
      }
      rows_.push_back(std::move(normal));
    } else if (place == 0) {
      row.stiffness = stiffness;
    }
    rows_.push_back(std::move(row));
  }
}

PushedObject Surroundings::object(const mjModel& model, const mjData& data, int body,
                                  const Vector3& position, const Vector3& normal,
                                  double force) const {
  PushedObject object;
  const std::size_t n = dofs_.size(), nv = static_cast<std::size_t>(model.nv);
  std::vector<mjtNum> jacobian(3 * nv);
  mj_jac(&model, &data, jacobian.data(), nullptr, position.data(), body);
  std::vector<double> away(n), u(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < 3; ++k) away[i] -= normal[k] * jacobian[k * nv + dofs_[i]];
    object.velocity += away[i] * rate_[dofs_[i]];
  }
  if (n == 0 || along(away, away) == 0.0) return {};
  object.root = model.body_rootid[body];
  object.force = force;
  mju_cholSolve(u.data(), H_.data(), away.data(), static_cast<int>(n));
  const double give = along(away, u);
  if (!(give * kHeaviest > 1.0)) return {};
  object.load = -force;
  for (std::size_t i = 0; i < n; ++i) u[i] /= give;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t dof = dofs_[i];
    for (std::size_t k = 0; k < n; ++k) object.mass += u[i] * M_[i * n + k] * u[k];
    object.damping += model.dof_damping[dof] * u[i] * u[i];
    object.ground_stiffness += model.jnt_stiffness[model.dof_jntid[dof]] * u[i] * u[i];
    object.load += u[i] * push_[i];
  }
  for (const Row& row : rows_) {
    const double way = along(row.way, u);
    object.mass += row.mass * way * way;
    object.damping += row.damping * way * way;
    object.ground_stiffness += row.stiffness * way * way;
  }
  object.recedes = std::move(away);
  object.motion = std::move(u);
  object.give = give;
  return object;
}

void Surroundings::share(std::vector<PushedObject>& objects) {
  std::map<int, std::vector<PushedObject*>> of_root;
  for (PushedObject& object : objects) {
    if (object.mass > 0.0) of_root[object.root].push_back(&object);
  }
  for (const auto& [root, together] : of_root) {
    if (together.size() < 2) continue;
    find_directions(together);
    for (PushedObject* object : together) {
      object->object = static_cast<std::uint32_t>(root);
      for (const PushedObject* other : together) {
        if (other != object) object->load -= along(object->motion, other->recedes) * other->force;
      }
    }
  }
}

}  // namespace haptic::mujoco
