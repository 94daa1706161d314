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
  for (std::size_t i = 0; i < coordinates_.size(); ++i) {
    if (coordinates_[i].kind != CoordinateKind::kQuaternion) continue;
    for (std::size_t part = 0; part < 4; ++part) {
      if (i + part >= coordinates_.size() ||
          coordinates_[i + part].kind != CoordinateKind::kQuaternion ||
          coordinates_[i + part].unit != Unit::kRadian) {
        throw SceneError("coordinate " + coordinates_[i].name +
                         ": a quaternion must have four parts in a row, in rad");
      }
    }
    quaternions_.push_back(static_cast<int>(i));
    i += 3;
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
    if (d > -std::numbers::pi && d <= std::numbers::pi) continue;  // as nearly always
    d = std::remainder(d, 2.0 * std::numbers::pi);
    if (d <= -std::numbers::pi) d = std::numbers::pi;  // (-pi, pi]
  }
  for (const int i : quaternions_) {
    const double norm = x.segment<4>(i).norm();
    const double sign = x.segment<4>(i).dot(x_probe.segment<4>(i)) < 0.0 ? -1.0 : 1.0;
    const double scale = norm > 0.0 ? sign / norm : 1.0;
    dx.segment<4>(i) = scale * x.segment<4>(i) - x_probe.segment<4>(i);
  }
}

}  // namespace haptic::core
