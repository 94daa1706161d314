#include "hw/simulated/reach_edge.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::hw {
namespace {

constexpr double kOnPlane = 1e-9;   // rad
constexpr double kParallel = 1e-6;  // sine of the angle between two planes

}  // namespace

void ReachEdge::add(const Eigen::Vector2d& x, const Eigen::Vector2d& at) noexcept {
  const double depth = (x - at).norm();
  if (!(depth > 0.0)) return;
  const auto end =
      std::remove_if(plane_.begin(), plane_.begin() + static_cast<std::ptrdiff_t>(count_),
                     [&](const Plane& plane) { return (plane.at - at).norm() > kLocal; });
  count_ = static_cast<std::size_t>(end - plane_.begin());
  if (count_ == kPlanes) {
    std::move(plane_.begin() + 1, plane_.end(), plane_.begin());
    --count_;
  }
  plane_[count_++] = {at, (x - at) / depth};
}

bool ReachEdge::within(const Eigen::Vector2d& x) const noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    if (plane_[i].depth(x) > kOnPlane) return false;
  }
  return true;
}

Eigen::Vector2d ReachEdge::nearest(const Eigen::Vector2d& x) const noexcept {
  if (within(x)) return x;
  Eigen::Vector2d best = x;
  double best_distance = -1.0;
  const auto offer = [&](const Eigen::Vector2d& y) {
    const double distance = (y - x).norm();
    if (!within(y) || (best_distance >= 0.0 && distance >= best_distance)) return;
    best = y;
    best_distance = distance;
  };
  std::size_t newest_violated = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Plane& a = plane_[i];
    const double depth = a.depth(x);
    if (depth > 0.0) {
      newest_violated = i;
      offer(x - depth * a.n);
    }
    for (std::size_t j = i + 1; j < count_; ++j) {
      const Plane& b = plane_[j];
      const double det = a.n[0] * b.n[1] - a.n[1] * b.n[0];
      if (std::abs(det) < kParallel) continue;
      const double ca = a.n.dot(a.at);
      const double cb = b.n.dot(b.at);
      offer({(ca * b.n[1] - cb * a.n[1]) / det, (a.n[0] * cb - b.n[0] * ca) / det});
    }
  }
  // Planes that contradict each other, of a reach that is not convex: the newest is the true one.
  const Plane& newest = plane_[newest_violated];
  return best_distance >= 0.0 ? best : Eigen::Vector2d(x - newest.depth(x) * newest.n);
}

}  // namespace haptic::hw
