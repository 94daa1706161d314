#include "server/scene/passivity_warning.hpp"

#include <algorithm>

#include "server/scene/own_dynamics.hpp"
#include "server/scene/problems.hpp"

namespace haptic::server {

std::vector<std::string> passivity_warnings(const Scene& scene) {
  std::vector<std::string> warnings;
  const double T = core::seconds(scene.loop.period);
  for (std::size_t d = 0; d < scene.devices.size(); ++d) {
    const core::RenderSettings& settings = scene.devices[d].settings;
    const DeviceScene& device = scene.devices[d];
    const core::VecA b = own_dynamics(device.source, device.kinematics->layout()).damping;
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
