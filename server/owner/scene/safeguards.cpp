// Direction guard and energy tank: every device has both unless its scene says `unguarded`.
#include <Eigen/LU>
#include <algorithm>

#include "haptic/core/linear/stiffness_coupling.hpp"
#include "server/owner/scene/parts.hpp"

namespace haptic::server {
namespace {

/// J: beyond it the user is told.
constexpr double kMuch = 0.5;

/// J: the most that a spring stores whose force Engage accepts and the limit allows,
/// 1/2 w^T |Z_q^-1| w.
double stored_at_engage(const core::PipelineConfig& device) {
  const Eigen::VectorXd window = device.scene.engage_window.cwiseMin(device.scene.force_limit);
  const auto& coupling = device.projection.coupling;
  const Eigen::MatrixXd Z =
      coupling ? Eigen::MatrixXd(coupling->matrix(device.scene.stiffness))
               : Eigen::MatrixXd(Eigen::VectorXd(device.scene.stiffness).asDiagonal());
  return 0.5 * window.dot(Z.inverse().cwiseAbs() * window);
}

}  // namespace

void add_guard(const Part<v1::DeviceScene>& part) {
  if (!part->has_unguarded()) {
    part->mutable_direction_guard();
  } else if (part->has_direction_guard() && part->passivity().has_tank()) {
    part.wrong("unguarded", "{ with direction_guard and passivity.tank }",
               "must be absent: both are named, so it leaves nothing out");
  }
}

void add_tank(const Part<v1::DeviceScene>& part, const core::PipelineConfig& device) {
  if (part->has_unguarded() || part->passivity().has_tank()) return;
  v1::EnergyTankScene& tank = *part->mutable_passivity()->mutable_tank();
  if (!part.good()) return;
  const double initial = stored_at_engage(device);
  tank.set_initial_j(initial);
  tank.set_capacity_j(std::max(core::TankSettings{}.capacity, initial));
}

std::vector<std::string> safeguard_warnings(const Scene& scene) {
  std::vector<std::string> warnings;
  for (std::size_t d = 0; d < scene.devices.size(); ++d) {
    const core::PipelineConfig& device = scene.devices[d].pipeline;
    const std::string unguarded = text({{"device", d}, "unguarded"}) + ": ";
    if (!device.scene.direction_guard) {
      warnings.push_back(unguarded +
                         "no direction_guard: force may push the user into a contact, unless the "
                         "renderer is per_contact");
    }
    if (!device.passivity.tank.enabled) {
      warnings.push_back(unguarded + "no passivity.tank: nothing bounds the energy given out");
    } else if (device.passivity.tank.initial > kMuch) {
      warnings.push_back(text({{"device", d}, "passivity", "tank", "initial_j"}) +
                         ": the force may give out " + decimal(device.passivity.tank.initial) +
                         " J after every Engage; a stiffer spring, a smaller engage_window_n or a "
                         "tank of the scene's own bounds it");
    }
  }
  return warnings;
}

}  // namespace haptic::server
