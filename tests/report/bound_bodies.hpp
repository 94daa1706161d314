#pragma once
/// Discs and walls in the plane, the proxy that they hold off, and what a client tells of them. The
/// coordinates x are those of a point, in m, or the two joints of a finger with three pads, in rad.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "haptic/client/planes.hpp"
#include "haptic/core/types.hpp"

namespace haptic::report {

/// A disc, or a wall if its radius is infinite: then the centre is on its surface.
struct BoundBody {
  Eigen::Vector2d centre{Eigen::Vector2d::Zero()};    ///< at t = 0, m
  Eigen::Vector2d velocity{Eigen::Vector2d::Zero()};  ///< m/s
  Eigen::Vector2d normal{Eigen::Vector2d::Zero()};    ///< of a wall
  double radius{0.0};                                 ///< m
  double stiffness{0.0};                              ///< N/m
  double told{1.0};                                   ///< what is told of that, by it
  [[nodiscard]] bool flat() const { return std::isinf(radius); }
  [[nodiscard]] Eigen::Vector2d place(double t) const { return centre + t * velocity; }
};

/// A gap as a function of x.
struct BoundGap {
  double phi{0.0}, gamma{0.0};
  Eigen::Vector2d g{Eigen::Vector2d::Zero()};
  Eigen::Matrix2d H{Eigen::Matrix2d::Zero()};
};

class BoundWorld {
 public:
  static constexpr double kPhalanx = 0.045;  ///< m, the first one's
  static constexpr std::size_t kMostGaps = 4;
  using Minimum = Eigen::Vector2d;

  std::vector<BoundBody> bodies{};  ///< at most 4, of a finger 1
  bool finger{false};
  double coupling{0.0};  ///< stiffness of the coupling, by x

  /// Those of every point and body at x. Returns how many.
  std::size_t gaps(double t, const Minimum& x, std::array<BoundGap, kMostGaps>& all) const;
  /// The minimum that Newton finds from `start` for the probe at p: curvature counts by its size,
  /// so that every step leads down, and is cut until the cost falls.
  [[nodiscard]] Minimum from(double t, const Minimum& p, const Minimum& start) const;
  /// The least of the minima from the last one, from the probe and from each body's surface.
  [[nodiscard]] Minimum least(double t, const Minimum& p, const Minimum& last) const;
  /// Contacts of the client library, of the gaps below `near`.
  [[nodiscard]] std::vector<client::Plane> told(double t, const core::VecX& x, double near,
                                                double uncertainty) const;

 private:
  struct Point {
    Eigen::Vector2d at, arm{Eigen::Vector2d::Zero()};  ///< arm: from the second joint
    bool turns{false};
  };
  struct Pad {
    std::size_t phalanx;
    double along;
  };
  static constexpr std::array kPads{Pad{0, 0.030}, Pad{1, 0.010}, Pad{1, 0.022}};

  std::size_t points(const Minimum& x, std::array<Point, kPads.size()>& all) const;
  [[nodiscard]] double cost(double t, const Minimum& p, const Minimum& x) const;
};

}  // namespace haptic::report
