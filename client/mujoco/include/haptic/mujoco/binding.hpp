#pragma once
/// Which part of a MuJoCo model the device moves: what of it is which coordinate of the device
/// (DeviceInfo::coordinates, the x of proto/README.md).

#include <mujoco/mujoco.h>

#include <cstddef>
#include <string>
#include <vector>

#include "haptic/client/types.hpp"

namespace haptic::mujoco {

/// One joint, point or pose of the model that follows coordinates of the device.
struct Binding {
  enum class Kind : unsigned char {
    kJoint,  ///< one coordinate: a hinge's angle, rad, or a slide's way, m
    kPoint,  ///< three: x, y, z of a site, or of a body's frame, in the world, m
    kPose    ///< seven: x, y, z, m, and the quaternion qx, qy, qz, qw of a body or site
  };
  Kind kind{Kind::kJoint};
  std::string name{};               ///< in the model
  std::size_t first_coordinate{0};  ///< of the device
  /// For a joint: qpos = offset + scale x. scale != 0; -1 if the two count in opposite directions.
  double scale{1.0}, offset{0.0};
};

[[nodiscard]] inline Binding joint(std::string name, std::size_t coordinate, double scale = 1.0,
                                   double offset = 0.0) {
  return {Binding::Kind::kJoint, std::move(name), coordinate, scale, offset};
}
[[nodiscard]] inline Binding point(std::string site_or_body, std::size_t first_coordinate) {
  return {Binding::Kind::kPoint, std::move(site_or_body), first_coordinate, 1.0, 0.0};
}
[[nodiscard]] inline Binding pose(std::string site_or_body, std::size_t first_coordinate) {
  return {Binding::Kind::kPose, std::move(site_or_body), first_coordinate, 1.0, 0.0};
}

/// Bindings of a model whose names are those of the device's coordinates (DeviceInfo::coordinates):
/// NAME.x .y .z is a point, with .qx .qy .qz .qw a pose, of the site or body NAME; any other
/// coordinate is the joint of its name. Throws std::invalid_argument, with the name that the model
/// has not. `joints`: those with another name, sign or zero, each
/// "NAME=COORDINATE[,SCALE[,OFFSET]]" with the model's and the device's names and qpos = OFFSET +
/// SCALE x: "knuckle=q_o1_mcp,-1,0.2". Several joints may have one coordinate, next to that of its
/// name too: "dip=q_o2_pip,0.67" lets a DIP follow.
[[nodiscard]] std::vector<Binding> by_name(
    const mjModel& model, const std::vector<client::VirtualCoordinate>& coordinates,
    const std::vector<std::string>& joints = {});

}  // namespace haptic::mujoco
