#include "pushed_object.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "constraint_rows.hpp"

namespace haptic::mujoco {

namespace {

constexpr double kHold = 0.05;                                  // s, h
constexpr std::size_t kOutside = static_cast<std::size_t>(-1);  // of the DoFs that count
constexpr double kHeaviest = 1e6;                               // kg; beyond, it is a wall
constexpr std::size_t kMostMotions = 6;                         // of Plane::object_direction
constexpr double kSlips = 1.0 - 1e-6;                           // of friction's cone
constexpr double kNewMotion = 1e-6;  // square of the part of a direction that is a new one

double along(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Directions with these cosines between them, by Cholesky's rule: each is a sum of those that came
/// before it, and of a new one if there is room.
void find_directions(const std::vector<const PushedObject*>& together) {
  std::vector<const PushedObject*> news;
  for (const PushedObject* object : together) {
    std::vector<double>& e = object->told->object_direction;
    double left = 1.0;
    for (const PushedObject* base : news) {
      const std::vector<double>& known = base->told->object_direction;
      const double cosine = object->give * along(object->motion, base->recedes) /
                            std::sqrt(object->give * base->give);
      const double told = std::inner_product(e.begin(), e.end(), known.begin(), 0.0);
      e.push_back((cosine - told) / known.back());
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

void Surroundings::look(const mjModel& model, mjData& data, const std::vector<mjtNum>& rate,
                        const std::set<int>& bodies) {
  rate_ = rate;
  dofs_.clear();
  rows_.clear();
  M_.clear();
  std::set<int> touched;  // DoFs
  for (int body : bodies) {
    while (body > 0 && model.body_dofnum[body] == 0) body = model.body_parentid[body];
    if (body > 0) touched.insert(model.body_dofadr[body]);
  }
  if (touched.empty()) return;
  find_dofs(model, data, touched);
  const std::size_t n = dofs_.size();
  find_masses(model, data);
  for (int i = 0; i < data.nefc; ++i) {
    if (counts(model, data, i)) look_at_row(model, data, i);
  }
  push_.assign(n, 0.0);
  H_.begin(n);
  for (const Mass& mass : M_) H_.reach(mass.i, mass.k);
  for (const Row& row : rows_) {
    std::size_t first = n;
    for (const Part& part : row.way) first = std::min(first, part.i);
    for (const Part& part : row.way) H_.reach(part.i, first);
  }
  for (const Mass& mass : M_) {
    if (mass.k <= mass.i) H_.add(mass.i, mass.k, mass.value);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t dof = dofs_[i];
    const double damping = model.dof_damping[dof];
    push_[i] = data.qfrc_smooth[dof] + data.qfrc_constraint[dof] + damping * rate[dof];
    H_.add(i, i, kHold * damping + kHold * kHold * model.jnt_stiffness[model.dof_jntid[dof]]);
  }
  for (const Row& row : rows_) {
    const double weight = row.mass + kHold * row.damping + kHold * kHold * row.stiffness;
    for (const Part& a : row.way) {
      push_[a.i] += a.value * row.taken;
      for (const Part& b : row.way) {
        if (b.i <= a.i) H_.add(a.i, b.i, weight * a.value * b.value);
      }
    }
  }
  H_.factor();
}

bool Surroundings::counts(const mjModel& model, const mjData& data, int row) const {
  const int type = data.efc_type[row];
  const mjtNum force = data.efc_force[row];
  if (type == mjCNSTR_EQUALITY) return true;
  if (type == mjCNSTR_FRICTION_DOF || type == mjCNSTR_FRICTION_TENDON) {
    return std::abs(force) < data.efc_frictionloss[row];
  }
  if (!is_contact(type)) return force > 0.0;
  const mjContact& contact = data.contact[data.efc_id[row]];
  const auto of_tool = [&](int geom) { return geom >= 0 && tool_->moves(model.geom_bodyid[geom]); };
  if (of_tool(contact.geom1) || of_tool(contact.geom2)) return false;
  if (type != mjCNSTR_CONTACT_ELLIPTIC) return force > 0.0;
  const mjtNum* const forces = data.efc_force + contact.efc_address;
  if (forces[0] <= 0.0 || row == contact.efc_address) return forces[0] > 0.0;
  double aside = 0.0;  // of what friction can hold
  for (int i = 1; i < contact.dim; ++i) {
    aside = std::hypot(aside, forces[i] / (contact.friction[i - 1] * forces[0]));
  }
  return aside < kSlips;
}

void Surroundings::find_dofs(const mjModel& model, const mjData& data,
                             const std::set<int>& touched) {
  const auto nv = static_cast<std::size_t>(model.nv);
  std::vector<int> tree(nv);  // of each DoF: the first DoF that moves with it
  for (std::size_t i = 0; i < nv; ++i) {
    const int parent = model.dof_parentid[i];
    tree[i] = parent < 0 ? static_cast<int>(i) : tree[static_cast<std::size_t>(parent)];
  }
  std::vector<std::set<int>> beside(nv);  // of a tree: those that rows connect with it
  std::pair<int, int> last{-1, -1};
  for (int row = 0; row < data.nefc; ++row) {
    if (!counts(model, data, row)) continue;
    int first = -1;
    for_parts(model, data, row, [&](int dof, double) {
      if (tool_->owns_dof(dof)) return;
      const int here = tree[static_cast<std::size_t>(dof)];
      if (first < 0) first = here;
      if (here == first || last == std::pair{first, here}) return;
      last = {first, here};
      beside[static_cast<std::size_t>(first)].insert(here);
      beside[static_cast<std::size_t>(here)].insert(first);
    });
  }
  // Sorted by their way from what is touched, the nearest last: that keeps the rows of H short.
  std::vector<int> group;
  std::vector<char> taken(nv, 0);
  const auto take = [&](int root) {
    if (taken[static_cast<std::size_t>(root)]++ == 0) group.push_back(root);
  };
  for (const int dof : touched) take(tree[static_cast<std::size_t>(dof)]);
  for (std::size_t i = 0; i < group.size(); ++i) {
    for (const int other : beside[static_cast<std::size_t>(group[i])]) take(other);
  }
  place_.assign(nv, kOutside);
  trees_.clear();
  for (auto root = group.rbegin(); root != group.rend(); ++root) {
    trees_.push_back(dofs_.size());
    for (auto i = static_cast<std::size_t>(*root); i < nv && tree[i] == *root; ++i) {
      if (tool_->owns_dof(static_cast<int>(i))) continue;
      place_[i] = dofs_.size();
      dofs_.push_back(i);
    }
  }
  trees_.push_back(dofs_.size());
}

void Surroundings::find_masses(const mjModel& model, mjData& data) {
  const auto nv = static_cast<std::size_t>(model.nv);
  std::vector<mjtNum> unit(nv), column(nv);
  for (std::size_t k = 0;; ++k) {  // the k-th DoF of all trees at once: none moves another's
    std::fill(unit.begin(), unit.end(), 0.0);
    bool any = false;
    for (std::size_t t = 0; t + 1 < trees_.size(); ++t) {
      if (trees_[t] + k >= trees_[t + 1]) continue;
      unit[dofs_[trees_[t] + k]] = 1.0;
      any = true;
    }
    if (!any) return;
    mj_mulM(&model, &data, column.data(), unit.data());
    for (std::size_t t = 0; t + 1 < trees_.size(); ++t) {
      if (trees_[t] + k >= trees_[t + 1]) continue;
      for (std::size_t i = trees_[t]; i < trees_[t + 1]; ++i) {
        if (column[dofs_[i]] != 0.0) M_.push_back({i, trees_[t] + k, column[dofs_[i]]});
      }
    }
  }
}

void Surroundings::look_at_row(const mjModel& model, const mjData& data, int index) {
  const auto add_row = [&](int at, double share, std::vector<Part>& way) {
    for_parts(model, data, at, [&](int dof, double value) {
      const std::size_t i = place_[static_cast<std::size_t>(dof)];
      if (i == kOutside) return;
      const auto same =
          std::find_if(way.begin(), way.end(), [i](const Part& part) { return part.i == i; });
      if (same != way.end()) {
        same->value += share * value;
      } else {
        way.push_back({i, share * value});
      }
    });
  };
  Row row;
  add_row(index, 1.0, row.way);
  if (row.way.empty()) return;
  const int type = data.efc_type[index];
  const int place = is_contact(type) ? index - data.contact[data.efc_id[index]].efc_address : 0;
  const mjtNum *KBI = data.efc_KBIP + 4 * index, inverse = 1.0 / data.efc_R[index];
  row.mass = inverse;
  row.damping = KBI[1] * inverse;
  for (const Part& part : row.way) {
    const std::size_t dof = dofs_[part.i];
    row.taken += part.value * (row.damping * rate_[dof] + row.mass * data.qacc[dof]);
  }
  const double stiffness = KBI[0] * KBI[2] * inverse;
  if (type == mjCNSTR_CONTACT_PYRAMIDAL) {  // two edges lie about the normal, which has the spring
    Row normal{{}, 0.0, 0.0, stiffness, 0.0};
    add_row(index, 0.5, normal.way);
    add_row(place % 2 == 0 ? index + 1 : index - 1, 0.5, normal.way);
    rows_.push_back(std::move(normal));
  } else if (place == 0) {
    row.stiffness = stiffness;
  }
  rows_.push_back(std::move(row));
}

std::optional<PushedObject> Surroundings::object(const mjModel& model, const mjData& data, int body,
                                                 const Vector3& position, double force,
                                                 client::Contact& told) const {
  const std::size_t n = dofs_.size(), nv = static_cast<std::size_t>(model.nv);
  if (n == 0 || model.body_weldid[body] == 0) return {};
  std::vector<mjtNum> jacobian(3 * nv);
  mj_jac(&model, &data, jacobian.data(), nullptr, position.data(), body);
  std::vector<double> away(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < 3; ++k) away[i] -= told.normal[k] * jacobian[k * nv + dofs_[i]];
  }
  if (along(away, away) == 0.0) return {};
  std::vector<double> u = away;
  H_.solve(u);
  const double give = along(away, u);
  if (!(give * kHeaviest > 1.0)) return {};
  told.load = -force;
  for (std::size_t i = 0; i < n; ++i) u[i] /= give;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t dof = dofs_[i];
    told.velocity += away[i] * rate_[dof];
    told.damping += model.dof_damping[dof] * u[i] * u[i];
    told.ground_stiffness += model.jnt_stiffness[model.dof_jntid[dof]] * u[i] * u[i];
    told.load += u[i] * push_[i];
  }
  for (const Mass& mass : M_) told.mass += u[mass.i] * mass.value * u[mass.k];
  for (const Row& row : rows_) {
    double way = 0.0;
    for (const Part& part : row.way) way += part.value * u[part.i];
    told.mass += row.mass * way * way;
    told.damping += row.damping * way * way;
    told.ground_stiffness += row.stiffness * way * way;
  }
  return PushedObject{&told, model.body_rootid[body], force, std::move(away), std::move(u), give};
}

void Surroundings::share(const std::vector<PushedObject>& objects) {
  std::map<int, std::vector<const PushedObject*>> of_root;
  for (const PushedObject& object : objects) of_root[object.root].push_back(&object);
  for (const auto& [root, together] : of_root) {
    if (together.size() < 2) continue;
    find_directions(together);
    for (const PushedObject* object : together) {
      object->told->object = static_cast<std::uint32_t>(root);
      for (const PushedObject* other : together) {
        if (other == object) continue;
        object->told->load -= along(object->motion, other->recedes) * other->force;
      }
    }
  }
}

}  // namespace haptic::mujoco
