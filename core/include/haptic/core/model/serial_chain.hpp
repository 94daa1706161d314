#pragma once
/// Chains of revolute and prismatic joints, fixed to the world or carried by a tracked palm, with
/// points or frames on their links as virtual coordinates, all in the world. A joint may name its
/// parent, so that several chains can share a base. f and J are exact (geometric Jacobian); any dim
/// X against dim Q.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/model/rigid_pose.hpp"

namespace haptic::core {

enum class JointKind : std::uint8_t { kRevolute, kPrismatic };

/// A joint and the link it moves. At q = 0 the link's frame is `origin` in its parent's frame.
struct ChainJoint {
  std::string name{};
  JointKind kind{JointKind::kRevolute};
  bool actuated{true};
  /// Link that carries this joint, by its joint's name; empty: the joint before (the base for the
  /// first); "base": the fixed frame, or the palm if one is tracked.
  std::string parent{};
  Pose3 origin{};              ///< m
  Point3 axis{0.0, 0.0, 1.0};  ///< in the link's frame; any length > 0
  double lower{-3.0};          ///< box of q*: rad (revolute) or m (prismatic)
  double upper{3.0};
};

struct ChainOutput {
  std::string name{};
  /// Link by its joint's name; empty: the last joint's; "base": the palm.
  std::string link{};
  OutputKind kind{OutputKind::kPoint};
  Pose3 offset{};  ///< in the link's frame, m; orientation matters to frames only
};

struct SerialChainParameters {
  std::optional<TrackedPalm> palm{};   ///< its six sensed DoFs come first in q
  std::vector<ChainJoint> joints{};    ///< in the order of q; a parent before its children
  std::vector<ChainOutput> outputs{};  ///< in the order of x
};

/// Coordinates are named OUTPUT.x .y .z (m) and, for frames, OUTPUT.qx .qy .qz .qw.
/// Throws SceneError naming the joint or output: names empty or repeated, an unknown parent or
/// link, limits out of order, a zero axis or quaternion, more than kMaxQ DoFs or kMaxX coordinates,
/// no output, an output that nothing moves, no actuated joint.
[[nodiscard]] std::unique_ptr<Kinematics> make_serial_chain(
    const SerialChainParameters& parameters);

}  // namespace haptic::core
