#include "hw/replay/stretch.hpp"

#include <cmath>
#include <utility>

namespace haptic::hw {
namespace {

std::vector<Pchip> curves(const std::vector<double>& time_s, const Columns& columns) {
  std::vector<Pchip> all;
  for (const auto& column : columns) all.emplace_back(time_s, column);
  return all;
}

}  // namespace

Stretch::Stretch(const std::vector<double>& time_s, const Columns& q)
    : begin_(core::duration(time_s.front())),
      end_(core::duration(time_s.back())),
      q_(curves(time_s, q)) {}

Stretch::Stretch(const std::vector<double>& time_s, const Columns& q, const Columns& x,
                 std::shared_ptr<const core::Kinematics> kinematics)
    : Stretch(time_s, q) {
  kinematics_ = std::move(kinematics);
  x_ = curves(time_s, x);
  for (std::size_t i = 0; i + 1 < time_s.size(); ++i) {
    in_reach_.push_back(leaves_reach(time_s[i], time_s[i + 1]) ? 0 : 1);
  }
}

/// Looks twice per millisecond: the edge of the reach is smooth on the scale of a hand's motion.
bool Stretch::leaves_reach(double from, double to) const {
  const int looks = static_cast<int>(std::ceil((to - from) / 0.0005));
  core::VecX x(static_cast<Eigen::Index>(x_.size()));
  core::VecQ q = core::VecQ::Zero(static_cast<Eigen::Index>(q_.size()));
  for (int i = 1; i < looks; ++i) {
    const double t = from + (to - from) * i / looks;
    for (std::size_t c = 0; c < x_.size(); ++c) x[static_cast<Eigen::Index>(c)] = x_[c](t);
    if (kinematics_->inverse(x, q) != core::InverseStatus::kExact) return true;
  }
  return false;
}

void Stretch::at(double t, core::VecQ& q) const noexcept {
  if (!in_reach_.empty() && in_reach_[x_[0].interval(t)] != 0) {
    core::VecX x(static_cast<Eigen::Index>(x_.size()));
    for (std::size_t c = 0; c < x_.size(); ++c) x[static_cast<Eigen::Index>(c)] = x_[c](t);
    static_cast<void>(kinematics_->inverse(x, q));
    return;
  }
  for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = q_[static_cast<std::size_t>(i)](t);
}

}  // namespace haptic::hw
