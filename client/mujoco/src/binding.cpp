#include "haptic/mujoco/binding.hpp"

#include <stdexcept>

namespace haptic::mujoco {

namespace {

bool has(const mjModel& model, mjtObj type, const std::string& name) {
  return mj_name2id(&model, type, name.c_str()) >= 0;
}

/// Whether the coordinates from `first` on are NAME followed by each of `ends`.
template <std::size_t kCount>
bool spells(const std::vector<client::VirtualCoordinate>& coordinates, std::size_t first,
            const std::string& name, const char* const (&ends)[kCount]) {
  if (first + kCount > coordinates.size()) return false;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (coordinates[first + i].name != name + ends[i]) return false;
  }
  return true;
}

}  // namespace

std::vector<Binding> by_name(const mjModel& model,
                             const std::vector<client::VirtualCoordinate>& coordinates) {
  std::vector<Binding> bindings;
  for (std::size_t i = 0; i < coordinates.size();) {
    const std::string& full = coordinates[i].name;
    const std::string name = full.substr(0, full.rfind('.'));
    if (has(model, mjOBJ_JOINT, full)) {
      bindings.push_back(joint(full, i++));
      continue;
    }
    if (!has(model, mjOBJ_SITE, name) && !has(model, mjOBJ_BODY, name)) {
      throw std::invalid_argument(
          "the device has a coordinate '" + full +
          "', but the model has no joint of this name and no site or body '" + name + "'");
    }
    if (!spells(coordinates, i, name, {".x", ".y", ".z"})) {
      throw std::invalid_argument("coordinate '" + full +
                                  "': a site or body follows x, y and z, or a whole pose");
    }
    const bool turns = spells(coordinates, i + 3, name, {".qx", ".qy", ".qz", ".qw"});
    bindings.push_back(turns ? pose(name, i) : point(name, i));
    i += turns ? 7 : 3;
  }
  return bindings;
}

}  // namespace haptic::mujoco
