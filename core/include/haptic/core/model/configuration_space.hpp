#pragma once
/// X: the coordinates of the virtual object, their names, units and kinds, and the difference
/// x (-) x_probe.
///
/// A rotation in X is the four parts of a unit quaternion, and so is the difference of two: sign
/// x/|x| - x_probe with the sign that makes it the shorter one (x and -x are one rotation). That is
/// a chord of the unit sphere: twice its length is 4 sin(theta/4), 0.3 % short of the angle at 0.5
/// rad and 1.0 % at 1 rad. It is smooth up to theta = pi, and its derivative is exactly -J, so no
/// Jacobian of a logarithm enters (core/METHOD.md#metric-and-limits). (The chord 2 sin(theta/2)
/// would be 4 % short at 1 rad and flat at pi.)

#include <string>
#include <vector>

#include "haptic/core/types.hpp"

namespace haptic::core {

enum class Unit : std::uint8_t { kMetre, kRadian };
/// kLinear: the real line (a length, or a joint angle between stops). kAngle: a full circle.
/// kQuaternion: a part of a unit quaternion (x, y, z, w: always four in a row), half radians.
enum class CoordinateKind : std::uint8_t { kLinear, kAngle, kQuaternion };

struct Coordinate {
  std::string name{};
  Unit unit{Unit::kMetre};
  CoordinateKind kind{CoordinateKind::kLinear};
  /// m, from this hinge to that of the next coordinate, which is parallel to it and which it
  /// carries; 0: it is no such hinge.
  double link{0.0};
};

class ConfigurationSpace {
 public:
  ConfigurationSpace() = default;
  explicit ConfigurationSpace(std::vector<Coordinate> coordinates);

  [[nodiscard]] int n_x() const noexcept { return static_cast<int>(coordinates_.size()); }
  [[nodiscard]] const std::vector<Coordinate>& coordinates() const noexcept { return coordinates_; }
  /// True if X has both metres and radians: a metric W_x is then required.
  [[nodiscard]] bool mixes_units() const noexcept;
  /// Index in x of each quaternion's first part.
  [[nodiscard]] const std::vector<int>& quaternions() const noexcept { return quaternions_; }
  /// dx = x (-) x_probe: componentwise; kAngle in (-pi, pi]; quaternions as above, x need not be
  /// normalised, and zero is taken as it is. Allocates nothing.
  void difference(const VecX& x, const VecX& x_probe, VecX& dx) const noexcept;

 private:
  std::vector<Coordinate> coordinates_{};
  std::vector<int> quaternions_{};  ///< index of the first of each four
};

}  // namespace haptic::core
