#include "server/scene/passivity_warning.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "server/base/figures.hpp"
#include "server/scene/own_dynamics.hpp"
#include "server/scene/problems.hpp"

namespace haptic::server {
namespace {

/// lambda_max of Z_q relative to 2 (b - B) / T, in which the loop's hold is paid for whatever the
/// direction (core/METHOD.md#sampled-data); infinite where an actuator has no damping left.
double share_of_damping(const DeviceScene& device, const core::VecA& b, double T) {
  const core::RenderSettings& settings = device.settings;
  Eigen::MatrixXd Z = device.projection.coupling->matrix(settings.stiffness);
  for (Eigen::Index i = 0; i < b.size(); ++i) {
    const double pays = 2.0 * (b[i] - settings.damping[i]) / T;
    if (!(pays > 0.0)) return std::numeric_limits<double>::infinity();
    Z.row(i) /= std::sqrt(pays);
    Z.col(i) /= std::sqrt(pays);
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Z, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .maxCoeff();
}

std::string coupled_warning(std::size_t d, double share, core::Duration T) {
  return "device[" + std::to_string(d) +
         "].impedance.stiffness_matrix: in its stiffest direction " + decimal(share) +
         " times 2 (b - B) / T (the device's damping b, rendered damping B, T = " +
         milliseconds(T) + "): such a spring can give out more energy than the device absorbs";
}

}  // namespace

std::vector<std::string> passivity_warnings(const Scene& scene) {
  std::vector<std::string> warnings;
  const double T = core::seconds(scene.loop.period);
  for (std::size_t d = 0; d < scene.devices.size(); ++d) {
    const core::RenderSettings& settings = scene.devices[d].settings;
    const DeviceScene& device = scene.devices[d];
    const core::VecA b = own_dynamics(device.source, device.kinematics->layout()).damping;
    if (device.projection.coupling) {
      if (b.size() == 0) continue;
      if (const double most = share_of_damping(device, b, T); !(most <= 1.0)) {
        warnings.push_back(coupled_warning(d, most, scene.loop.period));
      }
      continue;
    }
    for (Eigen::Index i = 0; i < b.size(); ++i) {
      const double highest = std::max(0.0, 2.0 * (b[i] - settings.damping[i]) / T);
      if (settings.stiffness[i] <= highest) continue;
      warnings.push_back("device[" + std::to_string(d) + "].impedance.stiffness_n_per_m[" +
                         std::to_string(i) + "] = " + decimal(settings.stiffness[i]) +
                         ": is above " + decimal(highest) +
                         " = 2 (b - B) / T (the device's damping b = " + decimal(b[i]) +
                         ", rendered damping B = " + decimal(settings.damping[i]) +
                         ", T = " + milliseconds(scene.loop.period) +
                         "): such a spring can give out more energy than the device absorbs");
    }
  }
  return warnings;
}

}  // namespace haptic::server
