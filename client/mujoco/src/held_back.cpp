#include "held_back.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "words.hpp"

namespace haptic::mujoco {

namespace {

constexpr double kFirst = 0.2, kEvery = 1.0;  // s
constexpr double kRests = 0.01;               // m/s
constexpr double kMost = 0.02;                // of what holds the tool back
constexpr double kLeast = 5e-4;               // rad or m of the coupling: less is not felt
constexpr double kSmall = 0.05;               // of the largest coordinate's: counts as this much
constexpr std::size_t kNamed = 3, kMostSaid = 100;

/// True if a body is the tool's, and a joint's coordinate moves it; any of a point or pose.
bool is_moved(const mjModel& model, const BoundTool& tool, int body, std::size_t coordinate) {
  if (!tool.moves(body)) return false;
  bool joints = false;
  for (const Place& place : tool.places()) {
    const bool joint = place.binding.kind == Binding::Kind::kJoint;
    joints = joints || (joint && place.binding.first_coordinate == coordinate);
  }
  for (; body > 0 && joints; body = model.body_parentid[body]) {
    for (int k = 0; k < model.body_dofnum[body]; ++k) {
      if (tool.coupled().way(model.body_dofadr[body] + k, coordinate) != 0.0) return true;
    }
  }
  return !joints;
}

/// Names of what touches the tool where the coordinate moves it, and what else may hold it.
std::string touched(const mjModel& model, const mjData& data, const BoundTool& tool,
                    std::size_t coordinate) {
  std::string text;
  std::set<std::pair<int, int>> pairs;
  bool friction = false, driven = false;
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& c = data.contact[i];
    if (c.efc_address < 0 || c.geom1 < 0 || c.geom2 < 0) continue;
    const int a = model.geom_bodyid[c.geom1], b = model.geom_bodyid[c.geom2];
    if (!is_moved(model, tool, a, coordinate) && !is_moved(model, tool, b, coordinate)) continue;
    friction = friction || c.dim > 1;
    if (!pairs.insert({c.geom1, c.geom2}).second || pairs.size() > kNamed) continue;
    text += (text.empty() ? "" : ", ") + name_of(model, c.geom1) + " on " + name_of(model, c.geom2);
  }
  for (int dof = 0; dof < model.nv; ++dof) {
    driven = driven || (tool.coupled().moves(dof) && data.qfrc_actuator[dof] != 0.0);
  }
  if (pairs.size() > kNamed) text += " and " + std::to_string(pairs.size() - kNamed) + " more";
  if (text.empty()) text = "nothing touches it";
  if (friction) text += "; friction is not told";
  if (driven) text += "; actuators are not told";
  return friction || driven ? text : text + "; a weld, a limit or a force of the model is not told";
}

}  // namespace

void HeldBack::restart() {
  told_.assign(tool_->coordinates(), 0.0);
  held_ = told_;
  samples_ = 0.0;
  left_ = kFirst;
}

void HeldBack::look(const mjModel& model, const mjData& data, std::vector<double> told) {
  std::vector<double> pulled = coupling_->pulled();
  leave_out(told, pulled);
  for (std::size_t c = 0; c < told.size(); ++c) {
    told_[c] += told[c];
    held_[c] += pulled[c];
  }
  const CoupledDofs& coupled = tool_->coupled();
  for (int dof = 0; dof < model.nv; ++dof) {
    if (!coupled.moves(dof)) continue;
    const double net = data.qfrc_smooth[dof] + data.qfrc_constraint[dof];
    for (std::size_t c = 0; c < told.size(); ++c) held_[c] -= coupled.way(dof, c) * net;
  }
  samples_ += 1.0;
  left_ -= aim_->seconds();
  if (left_ > 0.0) return;
  compare(model, data);
  restart();
  left_ = kEvery;
}

void HeldBack::leave_out(std::vector<double>& told, std::vector<double>& pulled) {
  rested_ += aim_->seconds();
  for (const Place& place : tool_->places()) {
    const std::size_t first = place.binding.first_coordinate;
    for (std::size_t k = 0; k < 3 && place.binding.kind != Binding::Kind::kJoint; ++k) {
      if (std::abs(aim_->rate(first + k)) > kRests) rested_ = 0.0;
    }
  }
  for (const Place& place : tool_->places()) {
    const std::size_t count = count_of(place.binding.kind);
    for (std::size_t k = rested_ < kFirst ? 0 : 3; k < count && count > 1; ++k) {
      const std::size_t i = place.binding.first_coordinate + k;
      told[i] = pulled[i] = 0.0;
    }
  }
}

void HeldBack::compare(const mjModel& model, const mjData& data) {
  double most = 0.0, worst = 0.0;
  for (std::size_t c = 0; c < held_.size(); ++c) {
    most = std::max(most, std::abs(held_[c] / samples_ / coupling_->stiffness(c)));
  }
  std::size_t at = 0;
  for (std::size_t c = 0; c < held_.size(); ++c) {
    const double way = std::abs(held_[c]) / samples_ / coupling_->stiffness(c);
    const double off = std::abs(told_[c] - held_[c]) / samples_ / coupling_->stiffness(c);
    const double part = off / std::max({way, kSmall * most, kLeast});
    if (part <= worst) continue;
    worst = part;
    at = c;
  }
  if (worst <= kMost) return;
  const std::string where = touched(model, data, *tool_, at);
  if (said_.size() >= kMostSaid || !said_.insert(where + std::to_string(at)).second) return;
  const double told = told_[at] / samples_, held = held_[at] / samples_;
  std::string name;
  for (const Place& place : tool_->places()) {
    const std::size_t first = place.binding.first_coordinate;
    if (at >= first && at < first + count_of(place.binding.kind)) name = place.binding.name;
  }
  char text[300];
  std::snprintf(text, sizeof text,
                "what is told is not what holds the tool back, but %.2f of it at coordinate %zu, "
                "'%.99s' (%.3g of %.3g N or N m): ",
                held != 0.0 ? told / held : 0.0, at, name.c_str(), told, held);
  warn(text + where);
}

}  // namespace haptic::mujoco
