#pragma once
/// Words of the tool to people.

#include <mujoco/mujoco.h>

#include <string>

namespace haptic::mujoco {

/// Name by which a person finds a geom in the model.
[[nodiscard]] std::string name_of(const mjModel& model, int geom);
/// "haptic::mujoco::Tool: " and the text, by mju_warning().
void warn(const std::string& text);

}  // namespace haptic::mujoco
