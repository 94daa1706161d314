/// The linkage of core/METHOD.md#finger-linkage as bodies. Carriage and body link turn and slide by
/// l_x and q_B. The others close the loop: a rod stands on its phalanx, so phalanx 1 turns until
/// point D lies at the height h1 above it, and rod 1, which is parallel to the phalanx's normal,
/// turns until the MCP axis lies as deep below it. Both see one right triangle of the sides c1 and
/// h1, from its two ends. Rod 2 and phalanx 2 do likewise with E and the PIP axis.
#include <cmath>

#include "drawing_parts.hpp"

namespace haptic::core {

namespace {

using Eigen::Vector3d;

Vector3d vector(const Point2& p) {
  return {p.x, p.y, 0.0};
}

DrawnMotion aim(int target, const Vector3d& point, double height) {
  return {
      .kind = DrawnMotion::Kind::kAim, .offset = height, .target = target, .target_point = point};
}

/// Flexion turns a phalanx from dorsal to palmar: about -z.
DrawnMotion flexion(int index) {
  return {.kind = DrawnMotion::Kind::kRotation,
          .axis = -Vector3d::UnitZ(),
          .value = DrawnValue::kX,
          .index = index};
}

constexpr double kFinger = 0.18;      // radius of a finger, of the proximal phalanx's length
constexpr double kLink = 0.035;       // likewise, of a link
constexpr double kMetacarpal = -1.4;  // likewise, its other end

}  // namespace

Drawing finger_drawing(const FingerDimensions& d) {
  const double finger = kFinger * d.proximal_phalanx, link = kLink * d.proximal_phalanx;
  const Vector3d origin = Vector3d::Zero(), rail = vector(d.rail_origin);
  const Vector3d along(std::cos(d.rail_angle), std::sin(d.rail_angle), 0.0);
  const Vector3d D = vector(d.body_d), E = vector(d.body_e);
  const Vector3d rod1(0.0, d.rod1, 0.0), rod2(0.0, d.rod2, 0.0);
  const Vector3d pip(d.proximal_phalanx, 0.0, 0.0), end(d.slider2_upper, 0.0, 0.0);
  constexpr DrawnPart kDevice = DrawnPart::kDevice, kTool = DrawnPart::kTool;
  enum { kBase, kCarriage, kBodyLink, kRod1, kGuide1, kRod2, kGuide2, kHand, kProximal };
  const Eigen::Quaterniond same = Eigen::Quaterniond::Identity();

  Drawing drawing;
  drawing.bodies = {
      {"base",
       kDevice,
       -1,
       origin,
       same,
       {},
       {{origin, rail, link}, {rail + d.l_x_lower * along, rail + d.l_x_upper * along, link}}},
      {"carriage",
       kDevice,
       kBase,
       rail,
       same,
       {slide_by_q(along, 0)},
       {{origin, origin, 2.0 * link}}},
      {"body_link",
       kDevice,
       kCarriage,
       origin,
       same,
       {turn_by_q(Vector3d::UnitZ(), 1)},
       {{origin, D, link}, {D, E, link}}},
      {"rod_1", kDevice, kBodyLink, D, same, {aim(kBase, origin, d.rod1)}, {{origin, rod1, link}}},
      {"guide_1", kDevice, kBase, origin, same, {aim(kBodyLink, D, d.rod1)}, {{origin, pip, link}}},
      {"rod_2", kDevice, kBodyLink, E, same, {aim(kGuide1, pip, d.rod2)}, {{origin, rod2, link}}},
      {"guide_2", kDevice, kGuide1, pip, same, {aim(kBodyLink, E, d.rod2)}, {{origin, end, link}}},
      {"metacarpal", kTool, -1, origin, same, {}, {{kMetacarpal * pip, origin, finger}}},
      {"proximal", kTool, kHand, origin, same, {flexion(0)}, {{origin, pip, finger}}},
      {"middle", kTool, kProximal, pip, same, {flexion(1)}, {{origin, end, finger}}},
  };
  drawing.forces = {{.actuator = 0, .body = kCarriage, .axis = along}};
  return drawing;
}

}  // namespace haptic::core
