#include "coupled_dofs.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "constraint_rows.hpp"

namespace haptic::mujoco {

namespace {

constexpr std::size_t kOutside = static_cast<std::size_t>(-1);
constexpr double kLoose = 0.01;     // 1/s^2: what holds a mass that nothing else does
constexpr double kLeastWay = 1e-6;  // smaller is the rows' softness
constexpr double kRoom = 0.5;       // rad or m, of a tendon that couples
constexpr double kLed = 0.02;       // share of a load that does not go into the rows

}  // namespace

CoupledDofs::CoupledDofs(const mjModel& model)
    : kinds_(static_cast<std::size_t>(model.nv)),
      bound_(static_cast<std::size_t>(model.nv)),
      slack_(static_cast<std::size_t>(model.nv)) {
  for (int i = 0; i < model.nv; ++i) {
    const int parent = model.dof_parentid[i];
    roots_.push_back(parent < 0 ? static_cast<std::size_t>(i)
                                : roots_[static_cast<std::size_t>(parent)]);
    masses_.push_back(kLoose * model.dof_M0[i]);
    springs_.push_back(model.jnt_stiffness[model.dof_jntid[i]]);
  }
}

void CoupledDofs::bind(int dof, std::size_t coordinate, double scale) {
  kinds_[static_cast<std::size_t>(dof)] = Kind::kBound;
  bound_[static_cast<std::size_t>(dof)] = {coordinate, scale};
}

void CoupledDofs::follow(const Follower& follower) {
  followers_.push_back(follower);
  kinds_[static_cast<std::size_t>(follower.dof)] = Kind::kOther;
}

void CoupledDofs::look(const mjModel& model, const mjData& data, std::size_t coordinates,
                       bool ever) {
  coordinates_ = coordinates;
  find_rows(model, data, ever);
  H_.begin(dofs_.size());
  for (std::size_t i = 0; i < dofs_.size(); ++i) H_.reach(i, 0);
  for (std::size_t i = 0; i < dofs_.size(); ++i) {
    const auto dof = static_cast<std::size_t>(dofs_[i]);
    H_.add(i, i, springs_[dof] + masses_[dof]);
  }
  for (const Row& row : rows_) {
    for (const auto& [a, to] : row.parts) {
      const std::size_t i = place_[static_cast<std::size_t>(a)];
      for (const auto& [b, from] : row.parts) {
        const std::size_t k = place_[static_cast<std::size_t>(b)];
        if (i != kOutside && k <= i) H_.add(i, k, row.stiffness * to * from);
      }
    }
  }
  H_.factor();
  find_ways();
  find_firm();
  if (ever) slack_ = led_;
}

bool CoupledDofs::counts(const mjModel& model, const mjData& data, int row, bool ever) const {
  const int type = data.efc_type[row];
  if (type == mjCNSTR_EQUALITY) return true;
  if (type == mjCNSTR_LIMIT_JOINT) return !ever && data.efc_force[row] > 0.0;
  if (type != mjCNSTR_LIMIT_TENDON || !ever) {
    return type == mjCNSTR_LIMIT_TENDON && data.efc_force[row] > 0.0;
  }
  double most = 0.0;
  for_parts(model, data, row,
            [&most](int, double value) { most = std::max(most, std::abs(value)); });
  const mjtNum* const range = model.tendon_range + 2 * data.efc_id[row];
  return range[1] - range[0] <= kRoom * most;
}

void CoupledDofs::find_rows(const mjModel& model, const mjData& data, bool ever) {
  std::vector<Row> all;
  for (int i = 0; i < data.nefc; ++i) {
    if (!counts(model, data, i, ever)) continue;
    const mjtNum* const KBI = data.efc_KBIP + 4 * i;
    all.push_back({{}, KBI[0] * KBI[2] / data.efc_R[i]});
    for_parts(model, data, i,
              [&](int dof, double value) { all.back().parts.emplace_back(dof, value); });
  }
  for (const Follower& one : followers_) {
    all.push_back({{{one.leader, -one.ratio}, {one.dof, 1.0}}, one.stiffness});
  }
  rows_.clear();
  std::vector<char> trees(kinds_.size()), held(kinds_.size());  // reached from a bound DoF, by rows
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    if (kinds_[i] == Kind::kBound) trees[roots_[i]] = 1;
  }
  const auto joins = [&](const std::pair<int, double>& part) {
    return trees[roots_[static_cast<std::size_t>(part.first)]] != 0;
  };
  for (bool more = true; more;) {
    more = false;
    for (Row& row : all) {
      if (std::none_of(row.parts.begin(), row.parts.end(), joins)) continue;
      for (const auto& [dof, value] : row.parts) {
        held[static_cast<std::size_t>(dof)] = trees[roots_[static_cast<std::size_t>(dof)]] = 1;
      }
      rows_.push_back(std::move(row));
      row.parts.clear();
      more = true;
    }
  }
  dofs_.clear();
  place_.assign(kinds_.size(), kOutside);
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    if (kinds_[i] != Kind::kOther || held[i] == 0) continue;
    place_[i] = dofs_.size();
    dofs_.push_back(static_cast<int>(i));
  }
}

void CoupledDofs::find_ways() {
  const std::size_t nv = kinds_.size();
  ways_.assign(nv * coordinates_, 0.0);
  moves_.assign(nv, 0);
  std::set<std::size_t> coordinates;
  for (std::size_t i = 0; i < nv; ++i) {
    if (kinds_[i] != Kind::kBound) continue;
    ways_[i * coordinates_ + bound_[i].first] = bound_[i].second;
    moves_[i] = 1;
    coordinates.insert(bound_[i].first);
  }
  for (const std::size_t c : coordinates) {
    std::vector<double> u(dofs_.size());
    bool any = false;
    for (const Row& row : rows_) {
      double there = 0.0;
      for (const auto& [dof, value] : row.parts) there += value * (bound(dof) ? way(dof, c) : 0.0);
      any = any || there != 0.0;
      for (const auto& [dof, value] : row.parts) {
        const std::size_t i = place_[static_cast<std::size_t>(dof)];
        if (i != kOutside) u[i] -= row.stiffness * value * there;
      }
    }
    if (!any) continue;
    H_.solve(u);
    for (std::size_t i = 0; i < u.size(); ++i) {
      if (std::abs(u[i]) < kLeastWay) continue;
      const auto dof = static_cast<std::size_t>(dofs_[i]);
      ways_[dof * coordinates_ + c] = u[i];
      moves_[dof] = 1;
    }
  }
}

void CoupledDofs::find_firm() {
  firm_.assign(kinds_.size(), 0);
  led_.assign(kinds_.size(), 0);
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    firm_[i] = kinds_[i] == Kind::kBound || springs_[i] > 0.0 ? 1 : 0;
  }
  for (std::size_t i = 0; i < dofs_.size(); ++i) {
    const auto dof = static_cast<std::size_t>(dofs_[i]);
    std::vector<double> unit(dofs_.size());
    unit[i] = 1.0;
    H_.solve(unit);
    firm_[dof] = unit[i] * masses_[dof] < 0.5 ? 1 : 0;
    led_[dof] = moves_[dof] != 0 && unit[i] * (masses_[dof] + springs_[dof]) < kLed ? 1 : 0;
  }
  for (const Follower& one : followers_) led_[static_cast<std::size_t>(one.dof)] = 1;
}

void CoupledDofs::take_off(const mjData& data, const std::vector<char>& owned,
                           mjtNum* applied) const {
  std::vector<double> left;  // the forces, and then what the rows do not take of them
  for (const int dof : dofs_) left.push_back(data.qfrc_passive[dof] - data.qfrc_bias[dof]);
  H_.solve(left);
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    const int dof = static_cast<int>(i);
    const bool slack = slack_[i] != 0 && owned[i] != 0;
    if (bound(dof) || (!moves(dof) && !slack)) continue;
    applied[i] += data.qfrc_bias[i] - data.qfrc_passive[i];
    if (!slack) applied[i] += (springs_[i] + masses_[i]) * left[place_[i]];
  }
}

double CoupledDofs::give(const std::vector<mjtNum>& v) const {
  double sum = 0.0;
  std::vector<double> load(dofs_.size());
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    if (kinds_[i] != Kind::kOther || firm_[i] == 0) continue;
    if (place_[i] == kOutside) {
      sum += v[i] * v[i] / springs_[i];
    } else {
      load[place_[i]] = v[i];
    }
  }
  std::vector<double> u = load;
  H_.solve(u);
  for (std::size_t i = 0; i < u.size(); ++i) sum += load[i] * u[i];
  return sum;
}

}  // namespace haptic::mujoco
