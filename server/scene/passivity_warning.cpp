#include "server/scene/passivity_warning.hpp"

#include <algorithm>

#include "server/scene/problems.hpp"

namespace haptic::server {
namespace {

/// The damping that the device has without us, per actuated DoF; the hand's is
/// not counted, it may let go. Empty for devices that move nothing.
core::VecA own_damping(const DeviceScene& device) {
  if (const auto* finger = std::get_if<hw::SimulatedFingerConfig>(&device.source)) {
    return core::VecA::Constant(1, finger->actuator_damping);
  }
  if (const auto* linear = std::get_if<hw::SimulatedLinearConfig>(&device.source)) {
    return device.kinematics->layout().select(linear->damping);
  }
  return {};
}

}  // namespace

std::vector<std::string> passivity_warnings(const Scene& scene) {
  std::vector<std::string> warnings;
  const double T = core::seconds(scene.loop.period);
  for (std::size_t d = 0; d < scene.devices.size(); ++d) {
    const core::RenderSettings& settings = scene.devices[d].settings;
    const core::VecA b = own_damping(scene.devices[d]);
    for (Eigen::Index i = 0; i < b.size(); ++i) {
      const double highest = std::max(0.0, 2.0 * (b[i] - settings.damping[i]) / T);
      if (settings.stiffness[i] <= highest) continue;
      warnings.push_back("device[" + std::to_string(d) + "].impedance.stiffness_n_per_m[" +
                         std::to_string(i) + "] = " + decimal(settings.stiffness[i]) +
                         ": is above " + decimal(highest) +
                         " = 2 (b - B) / T (the device's damping b = " + decimal(b[i]) +
                         ", rendered damping B = " + decimal(settings.damping[i]) +
                         ", T = " + decimal_ms(scene.loop.period) +
                         "): such a spring can give out more energy than the device absorbs");
    }
  }
  return warnings;
}

}  // namespace haptic::server
