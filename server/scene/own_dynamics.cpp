#include "server/scene/own_dynamics.hpp"

namespace haptic::server {

OwnDynamics own_dynamics(const hw::DeviceConfig& source, const core::DofLayout& layout) {
  if (const auto* finger = std::get_if<hw::SimulatedFingerConfig>(&source)) {
    return {core::VecA::Constant(1, finger->actuator_damping),
            core::VecA::Constant(1, finger->actuator_mass)};
  }
  if (const auto* linear = std::get_if<hw::SimulatedLinearConfig>(&source)) {
    if (linear->damping.size() != layout.n_q() || linear->mass.size() != layout.n_q()) return {};
    return {layout.select(linear->damping), layout.select(linear->mass)};
  }
  return {};
}

}  // namespace haptic::server
