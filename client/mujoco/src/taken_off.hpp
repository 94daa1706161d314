#pragma once
/// Switches off what a model itself does with joints that the device moves.

#include <string>

#include "bound_tool.hpp"

namespace haptic::mujoco {

/// Switches off in the model: limits and friction of joints that are bound or that constraints
/// lead, friction of their tendons. The hand that wears the device is where it is.
void take_off_limits(mjModel& model, const BoundTool& tool);
/// Switches off the actuators on joints that the device moves. Returns their names; empty: none.
[[nodiscard]] std::string take_off_actuators(mjModel& model, const BoundTool& tool);

}  // namespace haptic::mujoco
