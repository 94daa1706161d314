#include "aim.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::mujoco {

void Aim::begin(std::vector<double> x) {
  from_ = to_ = std::move(x);
  following_ = false;
}

void Aim::next(const std::vector<double>& probe, int steps, double seconds) {
  from_ = to_;
  steps_ = steps;
  taken_ = 0;
  part_ = 0.0;
  seconds_ = seconds;
  if (probe.empty()) return;
  std::vector<double> goal = probe;
  from_.resize(goal.size());
  to_.resize(goal.size());
  const double part = part_of_way(goal);
  for (std::size_t i = 0; i < goal.size(); ++i) to_[i] = from_[i] + part * (goal[i] - from_[i]);
  following_ = part == 1.0;
}

void Aim::step() {
  taken_ = std::min(taken_ + 1, steps_);
  part_ = static_cast<double>(taken_) / steps_;
}

double Aim::part_of_way(std::vector<double>& goal) const {
  double jump = 0.0, slow = 0.0;  // of the largest that is allowed at once, and of a slow period
  const auto count = [&](double way, bool turns) {
    jump = std::max(jump, way / (turns ? options_->jump_rad : options_->jump_m));
    slow = std::max(slow, way / (seconds_ * (turns ? options_->slow_rad_s : options_->slow_m_s)));
  };
  for (const Place& place : tool_->places()) {
    const std::size_t first = place.binding.first_coordinate;
    if (place.binding.kind == Binding::Kind::kJoint) {
      goal[first] = from_[first] + place.apart(from_[first], goal[first]);
      count(std::abs(goal[first] - from_[first]), place.turns);
      continue;
    }
    double way = 0.0, same = 0.0, length = 0.0;
    for (std::size_t i = first; i < first + 3; ++i) way = std::hypot(way, goal[i] - from_[i]);
    count(way, false);
    if (place.binding.kind == Binding::Kind::kPoint) continue;
    for (std::size_t i = first + 3; i < first + 7; ++i) {
      same += goal[i] * from_[i];
      length = std::hypot(length, goal[i]);
    }
    for (std::size_t i = first + 3; i < first + 7; ++i) {
      goal[i] *= (same < 0.0 ? -1.0 : 1.0) / length;
    }
    count(2.0 * std::acos(std::min(std::abs(same) / length, 1.0)), true);
  }
  if (jump <= 1.0 && following_) return 1.0;
  return slow <= 1.0 ? 1.0 : 1.0 / slow;
}

}  // namespace haptic::mujoco
