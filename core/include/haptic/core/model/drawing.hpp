#pragma once
/// A device as bodies that move, for a picture of it: an open tree whose frames follow from q and x
/// without any knowledge of the map. Same meaning, and the same numbers of enumerators, as
/// proto/haptic/v1/drawing.proto. Made at set-up; nothing here is for the loop.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

namespace haptic::core {

enum class DrawnPart : std::uint8_t {
  kDevice = 1,  ///< what the user wears or holds; moves with q
  kTool = 2,    ///< the virtual tool; moves with x
};

enum class DrawnValue : std::uint8_t { kQ = 1, kX = 2 };

struct DrawnMotion {
  enum class Kind : std::uint8_t {
    kRotation = 1,        ///< about `axis` by factor value + offset, rad
    kTranslation = 2,     ///< along `axis` by factor value + offset, m
    kOrientation = 3,     ///< by four values, a quaternion x, y, z, w
    kRotationVector = 4,  ///< by three values, axis times angle, rad
    /// About z, until `target_point` of body `target` has y = offset and x > 0: how a link of a
    /// closed linkage turns, whose angle is no function of a single value.
    kAim = 5,
  };
  Kind kind{Kind::kRotation};
  Eigen::Vector3d axis{Eigen::Vector3d::UnitZ()};  ///< unit
  DrawnValue value{DrawnValue::kQ};
  int index{0};  ///< of the value, or of the first of several
  double factor{1.0};
  double offset{0.0};  ///< rad or m
  int target{-1};      ///< kAim: a body that comes earlier
  Eigen::Vector3d target_point{Eigen::Vector3d::Zero()};
};

/// All points within `radius` of the line between two points of the body's frame, m. A sphere where
/// both are the same.
struct DrawnCapsule {
  Eigen::Vector3d from{Eigen::Vector3d::Zero()};
  Eigen::Vector3d to{Eigen::Vector3d::Zero()};
  double radius{0.0};
};

struct DrawnBody {
  std::string name{};
  DrawnPart part{DrawnPart::kDevice};
  int parent{-1};                                     ///< body, or -1 for the world
  Eigen::Vector3d position{Eigen::Vector3d::Zero()};  ///< in the parent's frame, m
  Eigen::Quaterniond orientation{Eigen::Quaterniond::Identity()};
  std::vector<DrawnMotion> motions{};  ///< after that, in this order, each in the frame so far
  std::vector<DrawnCapsule> capsules{};
};

/// Where an actuator acts: a force along `axis` at `point`, or a torque about it; both in the
/// frame of the body. A positive command pushes along the axis, which is the way the point moves
/// when the actuated DoF rises.
struct DrawnForce {
  int actuator{0};  ///< index in q_a
  int body{0};
  Eigen::Vector3d point{Eigen::Vector3d::Zero()};
  Eigen::Vector3d axis{Eigen::Vector3d::UnitZ()};  ///< unit
  bool torque{false};
};

struct Drawing {
  std::vector<DrawnBody> bodies{};  ///< a parent comes before its children
  std::vector<DrawnForce> forces{};
};

}  // namespace haptic::core
