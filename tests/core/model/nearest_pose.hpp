#pragma once
/// The pose of a finger nearest to a proxy by exhaustion: with nothing but the forward map.

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic/core/types.hpp"
#include "tests/support/finger_pose.hpp"

namespace haptic::core {

struct NearestPose {
  double distance{std::numeric_limits<double>::infinity()};  ///< ||.||_W
  VecQ q{};
};

/// Within box and sliders, on a grid that is refined five times.
inline NearestPose nearest_pose(const FingerDimensions& d, const VecX& x,
                                const Eigen::Matrix2d& W = Eigen::Matrix2d::Identity()) {
  NearestPose nearest;
  double l_from = d.l_x_lower, l_to = d.l_x_upper, t_from = d.q_B_lower, t_to = d.q_B_upper;
  for (int level = 0; level < 6; ++level) {
    constexpr int kSteps = 200;
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; j <= kSteps; ++j) {
        const Eigen::Vector2d q(l_from + (l_to - l_from) * i / kSteps,
                                t_from + (t_to - t_from) * j / kSteps);
        const FingerPose p = finger_pose(d, q[0], q[1]);
        if (p.status != MapStatus::kOk || p.c1 < d.slider1_lower || p.c1 > d.slider1_upper ||
            p.c2 < d.slider2_lower || p.c2 > d.slider2_upper) {
          continue;
        }
        const Eigen::Vector2d r(p.q_o1 - x[0], p.q_o2 - x[1]);
        const double distance = std::sqrt(r.dot(W * r));
        if (distance <= nearest.distance) nearest = {distance, q};
      }
    }
    const double half_l = (l_to - l_from) / kSteps * 3, half_t = (t_to - t_from) / kSteps * 3;
    l_from = std::max(d.l_x_lower, nearest.q[0] - half_l);
    l_to = std::min(d.l_x_upper, nearest.q[0] + half_l);
    t_from = std::max(d.q_B_lower, nearest.q[1] - half_t);
    t_to = std::min(d.q_B_upper, nearest.q[1] + half_t);
  }
  return nearest;
}

}  // namespace haptic::core
