#include "drawing_parts.hpp"

#include <algorithm>

namespace haptic::core {

void append(const Drawing& part, const DrawnPlace& place, Drawing& whole) {
  std::vector<int> at;  // of each body of the part, within the whole
  for (const DrawnBody& given : part.bodies) {
    const bool tool = given.part == DrawnPart::kTool;
    at.push_back(tool && !place.with_tool ? -1 : static_cast<int>(whole.bodies.size()));
    if (at.back() < 0) continue;
    DrawnBody body = given;
    body.name = place.prefix + body.name;
    if (body.parent >= 0) {
      body.parent = at[static_cast<std::size_t>(body.parent)];
    } else {
      body.parent = place.parent;
      body.position = place.position + place.orientation * body.position;
      body.orientation = place.orientation * body.orientation;
    }
    for (DrawnMotion& motion : body.motions) {
      motion.index += motion.value == DrawnValue::kQ ? place.first_q : place.first_x;
      if (motion.target >= 0) motion.target = at[static_cast<std::size_t>(motion.target)];
    }
    whole.bodies.push_back(std::move(body));
  }
  for (DrawnForce force : part.forces) {
    force.actuator += place.first_a;
    force.body = at[static_cast<std::size_t>(force.body)];
    whole.forces.push_back(force);
  }
}

double link_radius(double longest) noexcept {
  return std::clamp(0.04 * longest, 1e-3, 0.02);
}

DrawnMotion turn_by_q(const Eigen::Vector3d& axis, int index) {
  return {.kind = DrawnMotion::Kind::kRotation, .axis = axis, .index = index};
}

DrawnMotion slide_by_q(const Eigen::Vector3d& axis, int index) {
  return {.kind = DrawnMotion::Kind::kTranslation, .axis = axis, .index = index};
}

std::vector<DrawnMotion> place_by_x(int first) {
  std::vector<DrawnMotion> motions;
  for (int i = 0; i < 3; ++i) {
    motions.push_back({.kind = DrawnMotion::Kind::kTranslation,
                       .axis = Eigen::Vector3d::Unit(i),
                       .value = DrawnValue::kX,
                       .index = first + i});
  }
  return motions;
}

}  // namespace haptic::core
