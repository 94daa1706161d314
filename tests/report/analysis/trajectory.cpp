#include "tests/report/analysis/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "haptic/core/error.hpp"

namespace haptic::core {

namespace {

constexpr std::size_t kFewest = 3;  // a cycle of two samples encloses nothing

/// The pose of each point, or the nearest in reach; counts the latter.
std::vector<VecQ> poses(const Kinematics& kinematics, const std::vector<VecX>& path,
                        int& beyond_reach) {
  std::vector<VecQ> result;
  result.reserve(path.size());
  for (const VecX& x : path) {
    if (x.size() != kinematics.space().n_x() || !x.allFinite()) {
      throw SceneError("trajectory sample " + std::to_string(result.size()) + " of " +
                       std::to_string(x.size()) + " values: must be " +
                       std::to_string(kinematics.space().n_x()) + " finite numbers");
    }
    VecQ q(kinematics.layout().n_q());
    const InverseStatus status = kinematics.inverse(x, q);
    if (status == InverseStatus::kNotOffered) {
      throw SceneError("trajectory in X: the device's map offers no inverse");
    }
    beyond_reach += status == InverseStatus::kUnreachable ? 1 : 0;
    result.push_back(q);
  }
  return result;
}

}  // namespace

Trajectory sampled(const Kinematics& kinematics, const GraspCycle& grasp) {
  const double per_cycle = grasp.sample_rate / grasp.frequency;
  const int n = static_cast<int>(std::lround(per_cycle));
  if (!(std::abs(per_cycle - n) < 1e-9) || n < static_cast<int>(kFewest) || grasp.cycles < 1) {
    throw SceneError("grasp cycle of " + std::to_string(per_cycle) + " samples, " +
                     std::to_string(grasp.cycles) +
                     " times: must be a whole number >= 3, at least once");
  }
  Trajectory result;
  for (int i = 0; i < n * grasp.cycles; ++i) {
    // 2 pi f t, written as tests/report/STUDY.md#finite-difference-rule-finger_sign_change samples
    // it: t_i = i / rate.
    const double wt = 2.0 * std::numbers::pi * grasp.frequency * i / grasp.sample_rate;
    VecX x(2);
    x << grasp.offset1 + grasp.A1 * (1.0 - std::cos(wt)) / 2.0,
        grasp.offset2 + grasp.A2 * (1.0 - std::cos(wt - grasp.psi)) / 2.0;
    result.x_probe.push_back(x);
  }
  result.q = poses(kinematics, result.x_probe, result.beyond_reach);
  const auto begin = result.q.begin() + (grasp.cycles > 1 ? n : 0);
  result.cycle.assign(begin, begin + n);
  return result;
}

Trajectory recorded(const Kinematics& kinematics, std::vector<VecX> x_probe,
                    std::vector<char> gap_before) {
  if (x_probe.size() < kFewest) {
    throw SceneError("trajectory of " + std::to_string(x_probe.size()) +
                     " samples: must be at least 3");
  }
  Trajectory result;
  result.x_probe = std::move(x_probe);
  result.gap_before = std::move(gap_before);
  result.q = poses(kinematics, result.x_probe, result.beyond_reach);
  result.cycle = result.q;
  result.closed_by_line = true;

  double length = 0.0;
  for (std::size_t i = 0; i + 1 < result.x_probe.size(); ++i) {
    length += (result.x_probe[i + 1] - result.x_probe[i]).norm();
  }
  const double mean_step = length / static_cast<double>(result.x_probe.size() - 1);
  const VecX& from = result.x_probe.back();
  const VecX gap = result.x_probe.front() - from;
  const int steps = mean_step > 0.0 ? static_cast<int>(std::ceil(gap.norm() / mean_step)) : 0;
  std::vector<VecX> line;
  for (int i = 1; i < steps; ++i) line.emplace_back(from + gap * (static_cast<double>(i) / steps));
  int beyond = 0;  // of the line, which nobody measured
  for (const VecQ& q : poses(kinematics, line, beyond)) result.cycle.push_back(q);
  return result;
}

}  // namespace haptic::core
