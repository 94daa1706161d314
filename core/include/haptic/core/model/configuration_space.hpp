#pragma once
/// X: the coordinates of the virtual object, their names, units and kinds, and the difference
/// x (-) x_probe taken in tangent coordinates.

#include <string>
#include <vector>

#include "haptic/core/types.hpp"

namespace haptic::core {

enum class Unit : std::uint8_t { kMetre, kRadian };
/// kLinear: the real line (a length, or a joint angle between stops). kAngle: a full circle.
enum class CoordinateKind : std::uint8_t { kLinear, kAngle };

struct Coordinate {
  std::string name{};
  Unit unit{Unit::kMetre};
  CoordinateKind kind{CoordinateKind::kLinear};
};

class ConfigurationSpace {
 public:
  ConfigurationSpace() = default;
  explicit ConfigurationSpace(std::vector<Coordinate> coordinates);

  [[nodiscard]] int n_x() const noexcept { return static_cast<int>(coordinates_.size()); }
  [[nodiscard]] const std::vector<Coordinate>& coordinates() const noexcept { return coordinates_; }
  /// True where metres and radians stand side by side: a metric W_x is then required.
  [[nodiscard]] bool mixes_units() const noexcept;
  /// dx = x (-) x_probe: componentwise; kAngle in (-pi, pi]. Allocates nothing.
  void difference(const VecX& x, const VecX& x_probe, VecX& dx) const noexcept;

 private:
  std::vector<Coordinate> coordinates_{};
};

}  // namespace haptic::core
