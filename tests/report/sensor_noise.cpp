#include "tests/report/sensor_noise.hpp"

#include <cmath>
#include <numbers>

namespace haptic::report {
namespace {

constexpr double kBits12 = 4096.0, kBits14 = 16384.0, kTurn = 2.0 * std::numbers::pi;

}  // namespace

SensorNoise sensor_noise(const std::string& wanted) noexcept {
  for (const SensorNoise noise : kSensorNoises) {
    if (name(noise) == wanted) return noise;
  }
  return SensorNoise::kNone;
}

Sensors::Sensors(SensorNoise noise, const core::Kinematics& map, std::uint64_t seed)
    : gaussian_(seed) {
  for (const core::DofSpec& dof : map.dofs()) {
    const bool metres = dof.unit == core::Unit::kMetre;
    const double range = dof.upper - dof.lower, turn = metres ? range : kTurn;
    switch (noise) {
      case SensorNoise::kNone:
        dofs_.push_back({});
        break;
      case SensorNoise::kScene:
        dofs_.push_back({metres ? 2e-6 : 2e-4});
        break;
      case SensorNoise::kPot12:
        dofs_.push_back({0.22 * range / kBits12, range / kBits12});
        break;
      case SensorNoise::kEncoder14:
        dofs_.push_back({0.06 / 360.0 * turn, turn / kBits14});
        break;
      case SensorNoise::kRough:
        dofs_.push_back({metres ? 5e-6 : 0.05 * kDegree});
        break;
    }
  }
}

core::VecQ Sensors::read(core::VecQ q) {
  for (std::size_t i = 0; i < dofs_.size(); ++i) {
    double& value = q[static_cast<Eigen::Index>(i)];
    value += dofs_[i].sigma * gaussian_();
    if (dofs_[i].quantum > 0.0) value = dofs_[i].quantum * std::round(value / dofs_[i].quantum);
  }
  return q;
}

}  // namespace haptic::report
