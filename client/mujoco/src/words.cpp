#include "words.hpp"

#include <algorithm>

namespace haptic::mujoco {

std::string name_of(const mjModel& model, int geom) {
  const char* const name = mj_id2name(&model, mjOBJ_GEOM, geom);
  if (name != nullptr) return "geom '" + std::string(name) + "'";
  const char* const body = mj_id2name(&model, mjOBJ_BODY, model.geom_bodyid[geom]);
  const std::string number = "geom " + std::to_string(geom);
  return body == nullptr ? number : number + " of body '" + body + "'";
}

void warn(const std::string& text) {
  std::string whole = "haptic::mujoco::Tool: " + text;
  std::replace(whole.begin(), whole.end(), '%', '_');  // to later releases it is a format
  mju_warning(whole.c_str());
}

}  // namespace haptic::mujoco
