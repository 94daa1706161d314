// Energy tank and passivity observer of a device, and springs that its damping cannot pay for.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "server/base/figures.hpp"
#include "server/owner/scene/parts.hpp"

namespace haptic::server {
namespace {

core::TankSettings read_tank(const Fields& part) {
  core::TankSettings tank;
  tank.enabled = true;
  part.numbers({{"capacity_j", &tank.capacity, Allowed::kPositive},
                {"initial_j", &tank.initial, Allowed::kNotNegative},
                {"allowed_power_w", &tank.allowed_power, Allowed::kNotNegative}});
  if (tank.initial > tank.capacity) {
    part.wrong("initial_j", decimal(tank.initial),
               "must be at most capacity_j, " + decimal(tank.capacity));
  }
  return tank;
}

/// Default: the device's own dynamics, if they are known.
std::optional<Fields::Numbers> known(const core::VecA& own) {
  return own.size() > 0 ? std::optional<Fields::Numbers>(own) : std::nullopt;
}

core::ObserverSettings read_observer(const Fields& part, int n_a, const hw::OwnDynamics& own) {
  core::ObserverSettings observer;
  observer.enabled = true;
  part.numbers({{"allowance_j", &observer.allowance, Allowed::kNotNegative},
                {"forgetting_j", &observer.forgetting, Allowed::kNotNegative}});
  observer.inertia = part.per_actuated("inertia_kg", Allowed::kPositive, n_a, known(own.inertia));
  observer.slowest =
      part.per_actuated("slowest_m_per_s", Allowed::kNotNegative, n_a, filled(n_a, 0.0));
  return observer;
}

/// lambda_max of Z_q relative to 2 (b - B) / T, in which the loop's hold is paid for whatever the
/// direction (core/METHOD.md#sampled-data); infinite where an actuator has no damping left.
double share_of_damping(const core::PipelineConfig& device, const core::VecA& b, double T) {
  const core::RenderSettings& settings = device.scene;
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

}  // namespace

void read_passivity(const Part<v1::PassivityScene>& part, DeviceScene& device) {
  const int n_a = n_a_of(device);
  const hw::OwnDynamics own =
      device.source && device.pipeline.kinematics
          ? device.source->own_dynamics(device.pipeline.kinematics->layout())
          : hw::OwnDynamics{};
  core::PassivitySettings& settings = device.pipeline.passivity;
  if (!part->has_tank() && !part->has_observer()) {
    part.missing("tank", "tank {} or observer {}, or both");
  }
  if (part->has_tank()) {
    const auto tank = part.part<v1::EnergyTankScene>("tank");
    settings.tank = read_tank(tank);
    if (own.inertia.size() > 0 || tank->inertia_kg_size() > 0) {
      settings.device_inertia =
          tank.per_actuated("inertia_kg", Allowed::kPositive, n_a, known(own.inertia));
    }
  }
  if (part->has_observer()) {
    settings.observer = read_observer(part.part<v1::PassivityObserverScene>("observer"), n_a, own);
  }
  settings.device_damping = part.per_actuated("device_damping_n_s_per_m", Allowed::kNotNegative,
                                              n_a, known(own.damping).value_or(filled(n_a, 0.0)));
}

std::vector<std::string> passivity_warnings(const Scene& scene) {
  std::vector<std::string> warnings;
  const double T = core::seconds(scene.loop.period);
  const std::string period = "T = " + milliseconds(scene.loop.period) +
                             "): such a spring can give out more energy than the device absorbs";
  for (std::size_t d = 0; d < scene.devices.size(); ++d) {
    const core::PipelineConfig& device = scene.devices[d].pipeline;
    const core::RenderSettings& settings = device.scene;
    const core::VecA b = scene.devices[d].source->own_dynamics(device.kinematics->layout()).damping;
    const auto at = [d](const FieldStep& field) {
      return text({{"device", d}, "impedance", field});
    };
    if (b.size() > 0 && device.projection.coupling) {
      const double share = share_of_damping(device, b, T);
      if (share <= 1.0) continue;
      warnings.push_back(at("stiffness_matrix") + ": in its stiffest direction " + decimal(share) +
                         " times 2 (b - B) / T (the device's damping b, rendered damping B, " +
                         period);
      continue;
    }
    for (Eigen::Index i = 0; i < b.size(); ++i) {
      const double highest = std::max(0.0, 2.0 * (b[i] - settings.damping[i]) / T);
      if (settings.stiffness[i] <= highest) continue;
      warnings.push_back(at({"stiffness_n_per_m", static_cast<std::size_t>(i)}) + " = " +
                         decimal(settings.stiffness[i]) + ": is above " + decimal(highest) +
                         " = 2 (b - B) / T (the device's damping b = " + decimal(b[i]) +
                         ", rendered damping B = " + decimal(settings.damping[i]) + ", " + period);
    }
  }
  return warnings;
}

}  // namespace haptic::server
