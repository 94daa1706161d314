#include "contact_ids.hpp"

namespace haptic::mujoco {

void ContactIds::begin() {
  for (auto& [pair, places] : pairs_) {
    for (Place& place : places) {
      place.before = place.now;
      place.now = false;
    }
  }
}

std::uint32_t ContactIds::id(const std::pair<int, int>& pair, const Vector3& on_tool) {
  auto& places = pairs_[pair];
  Place* best = nullptr;
  double nearest = 0.0;
  for (Place& place : places) {
    if (place.now) continue;
    const Vector3 apart = add(place.on_tool, -1.0, on_tool);
    const double distance = dot(apart, apart);
    const bool better = best == nullptr || (place.before && !best->before) ||
                        (place.before == best->before && distance < nearest);
    if (!better) continue;
    best = &place;
    nearest = distance;
  }
  if (best == nullptr) {
    places.push_back({++last_, {}, false, false});
    best = &places.back();
  }
  best->on_tool = on_tool;
  best->now = true;
  return best->id;
}

}  // namespace haptic::mujoco
