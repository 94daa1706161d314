#include "haptic/mujoco/binding.hpp"

#include <charconv>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

namespace haptic::mujoco {

namespace {

bool has(const mjModel& model, mjtObj type, const std::string& name) {
  return mj_name2id(&model, type, name.c_str()) >= 0;
}

/// True if the coordinates from `first` on are NAME followed by each of `ends`.
template <std::size_t kCount>
bool spells(const std::vector<client::VirtualCoordinate>& coordinates, std::size_t first,
            const std::string& name, const char* const (&ends)[kCount]) {
  if (first + kCount > coordinates.size()) return false;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (coordinates[first + i].name != name + ends[i]) return false;
  }
  return true;
}

/// "NAME=COORDINATE[,SCALE[,OFFSET]]"
Binding joint_of(const std::string& text,
                 const std::vector<client::VirtualCoordinate>& coordinates) {
  const auto refuse = [&text](const std::string& why) {
    throw std::invalid_argument("joint '" + text + "': " + why);
  };
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || text.ends_with(','))
    refuse("must be NAME=COORDINATE[,SCALE[,OFFSET]]");
  std::istringstream rest(text.substr(equals + 1));
  std::string coordinate, number;
  std::getline(rest, coordinate, ',');
  std::size_t at = 0;
  while (at < coordinates.size() && coordinates[at].name != coordinate) ++at;
  if (at == coordinates.size()) refuse("the device has no coordinate '" + coordinate + "'");
  Binding bound = joint(text.substr(0, equals), at);
  for (double* const value : {&bound.scale, &bound.offset}) {
    if (!std::getline(rest, number, ',')) break;
    const char* const last = number.data() + number.size();
    const auto [end, error] = std::from_chars(number.data(), last, *value);  // in no locale
    if (error != std::errc{} || end != last || !std::isfinite(*value)) {
      refuse("'" + number + "' must be a finite number");
    }
  }
  if (!rest.eof()) refuse("must be NAME=COORDINATE[,SCALE[,OFFSET]]");
  return bound;
}

}  // namespace

std::vector<Binding> by_name(const mjModel& model,
                             const std::vector<client::VirtualCoordinate>& coordinates,
                             const std::vector<std::string>& joints) {
  std::vector<Binding> bindings;
  std::set<std::size_t> said;
  std::set<std::string> named;
  for (const std::string& text : joints) {
    bindings.push_back(joint_of(text, coordinates));
    said.insert(bindings.back().first_coordinate);
    named.insert(bindings.back().name);
  }
  for (std::size_t i = 0; i < coordinates.size();) {
    const std::string& full = coordinates[i].name;
    const std::string name = full.substr(0, full.rfind('.'));
    if (has(model, mjOBJ_JOINT, full) && !named.contains(full)) {
      // It leads those of another name.
      bindings.insert(said.contains(i) ? bindings.begin() : bindings.end(), joint(full, i));
      ++i;
      continue;
    }
    if (said.contains(i)) {
      ++i;
      continue;
    }
    if (!has(model, mjOBJ_SITE, name) && !has(model, mjOBJ_BODY, name)) {
      throw std::invalid_argument(
          "the device has a coordinate '" + full +
          "', but the model has no joint of this name and no site or body '" + name +
          "'; say which joint it is: JOINT=" + full + "[,SCALE[,OFFSET]]");
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
