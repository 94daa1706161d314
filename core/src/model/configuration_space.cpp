#include "haptic/core/model/configuration_space.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptic/core/error.hpp"

namespace haptic::core {

ConfigurationSpace::ConfigurationSpace(std::vector<Coordinate> coordinates)
    : coordinates_(std::move(coordinates)) {
  if (coordinates_.empty() || coordinates_.size() > static_cast<std::size_t>(kMaxX)) {
    throw SceneError("virtual configuration with " + std::to_string(coordinates_.size()) +
                     " coordinates: must have 1 to " + std::to_string(kMaxX));
  }
  for (const Coordinate& c : coordinates_) {
    if (c.kind == CoordinateKind::kAngle && c.unit != Unit::kRadian) {
      throw SceneError("coordinate " + c.name + ": an angle must be in rad");
    }
  }
}

bool ConfigurationSpace::mixes_units() const noexcept {
  return std::any_of(coordinates_.begin(), coordinates_.end(),
                     [this](const Coordinate& c) { return c.unit != coordinates_.front().unit; });
}

void ConfigurationSpace::difference(const VecX& x, const VecX& x_probe, VecX& dx) const noexcept {
  dx = x - x_probe;
  for (std::size_t i = 0; i < coordinates_.size(); ++i) {
    if (coordinates_[i].kind != CoordinateKind::kAngle) continue;
    double& d = dx[static_cast<Eigen::Index>(i)];
    d = std::remainder(d, 2.0 * std::numbers::pi);
    if (d <= -std::numbers::pi) d = std::numbers::pi;  // (-pi, pi]
  }
}

}  // namespace haptic::core
