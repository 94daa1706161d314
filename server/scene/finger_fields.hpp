#pragma once
/// The scene's numbers of the finger and of the simulated hand, each tied to its place in the
/// struct it fills: one table serves the defaults, the checks and the reading.

#include <limits>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/open_device.hpp"

namespace haptic::server {

template <typename Struct>
struct NumberField {
  const char* name;  ///< in scene.proto
  double& (*at)(Struct&);
  double lowest;  ///< allowed from here on
};

inline constexpr double kAny = -std::numeric_limits<double>::max();

#define HAPTIC_AT(Struct, member) [](Struct& s) -> double& { return s.member; }

inline constexpr NumberField<core::FingerDimensions> kFingerFields[] = {
    {"proximal_phalanx_m", HAPTIC_AT(core::FingerDimensions, proximal_phalanx), 0.0},
    {"rail_origin_x_m", HAPTIC_AT(core::FingerDimensions, rail_origin.x), kAny},
    {"rail_origin_y_m", HAPTIC_AT(core::FingerDimensions, rail_origin.y), kAny},
    {"rail_angle_rad", HAPTIC_AT(core::FingerDimensions, rail_angle), kAny},
    {"body_d_x_m", HAPTIC_AT(core::FingerDimensions, body_d.x), kAny},
    {"body_d_y_m", HAPTIC_AT(core::FingerDimensions, body_d.y), kAny},
    {"body_e_x_m", HAPTIC_AT(core::FingerDimensions, body_e.x), kAny},
    {"body_e_y_m", HAPTIC_AT(core::FingerDimensions, body_e.y), kAny},
    {"rod1_m", HAPTIC_AT(core::FingerDimensions, rod1), 0.0},
    {"rod2_m", HAPTIC_AT(core::FingerDimensions, rod2), 0.0},
    {"slider1_lower_m", HAPTIC_AT(core::FingerDimensions, slider1_lower), 0.0},
    {"slider1_upper_m", HAPTIC_AT(core::FingerDimensions, slider1_upper), 0.0},
    {"slider2_lower_m", HAPTIC_AT(core::FingerDimensions, slider2_lower), 0.0},
    {"slider2_upper_m", HAPTIC_AT(core::FingerDimensions, slider2_upper), 0.0},
    {"l_x_lower_m", HAPTIC_AT(core::FingerDimensions, l_x_lower), kAny},
    {"l_x_upper_m", HAPTIC_AT(core::FingerDimensions, l_x_upper), kAny},
    {"q_B_lower_rad", HAPTIC_AT(core::FingerDimensions, q_B_lower), kAny},
    {"q_B_upper_rad", HAPTIC_AT(core::FingerDimensions, q_B_upper), kAny},
};

inline constexpr NumberField<hw::SimulatedFingerConfig> kSimulatedFields[] = {
    {"target_mcp_rad", HAPTIC_AT(hw::SimulatedFingerConfig, target_mcp), kAny},
    {"target_pip_rad", HAPTIC_AT(hw::SimulatedFingerConfig, target_pip), kAny},
    {"hand_stiffness", HAPTIC_AT(hw::SimulatedFingerConfig, hand_stiffness), 0.0},
    {"hand_damping", HAPTIC_AT(hw::SimulatedFingerConfig, hand_damping), 0.0},
    {"actuator_mass_kg", HAPTIC_AT(hw::SimulatedFingerConfig, actuator_mass), 0.0},
    {"actuator_damping", HAPTIC_AT(hw::SimulatedFingerConfig, actuator_damping), 0.0},
    {"actuator_friction_n", HAPTIC_AT(hw::SimulatedFingerConfig, actuator_friction), 0.0},
    {"actuator_force_limit_n", HAPTIC_AT(hw::SimulatedFingerConfig, actuator_force_limit), 0.0},
    {"noise_l_x_m", HAPTIC_AT(hw::SimulatedFingerConfig, noise_l_x), 0.0},
    {"noise_q_B_rad", HAPTIC_AT(hw::SimulatedFingerConfig, noise_q_B), 0.0},
    {"resolution_l_x_m", HAPTIC_AT(hw::SimulatedFingerConfig, resolution_l_x), 0.0},
    {"resolution_q_B_rad", HAPTIC_AT(hw::SimulatedFingerConfig, resolution_q_B), 0.0},
};

#undef HAPTIC_AT

}  // namespace haptic::server
