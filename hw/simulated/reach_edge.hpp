#pragma once
/// The edge of the exoskeleton's reach near the finger, kept as a few half-planes in joint space:
/// n_i^T x <= n_i^T at_i, each from one search for the nearest pose in reach. One plane describes a
/// smooth edge, two or more through one point a corner.

#include <Eigen/Core>
#include <array>

namespace haptic::hw {

class ReachEdge {
 public:
  /// Adds what a search from `x` (rad) found: the nearest pose in reach is at `at`. Forgets planes
  /// that touch the edge further than kLocal from there, and the oldest if there is no room.
  void add(const Eigen::Vector2d& x, const Eigen::Vector2d& at) noexcept;
  void clear() noexcept { count_ = 0; }
  [[nodiscard]] bool known() const noexcept { return count_ > 0; }

  /// The point nearest to x within all planes; x itself if it is within. Allocates nothing.
  [[nodiscard]] Eigen::Vector2d nearest(const Eigen::Vector2d& x) const noexcept;

 private:
  static constexpr std::size_t kPlanes = 4;
  static constexpr double kLocal = 0.05;  ///< rad; the reach is not convex, its planes hold nearby
  struct Plane {
    Eigen::Vector2d at{Eigen::Vector2d::Zero()};
    Eigen::Vector2d n{Eigen::Vector2d::Zero()};  ///< outward, unit length
    [[nodiscard]] double depth(const Eigen::Vector2d& x) const { return n.dot(x - at); }
  };
  [[nodiscard]] bool within(const Eigen::Vector2d& x) const noexcept;

  std::array<Plane, kPlanes> plane_{};  ///< oldest first
  std::size_t count_{0};
};

}  // namespace haptic::hw
