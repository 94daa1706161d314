#pragma once
/// Chains of revolute and prismatic joints, fixed to the world or carried by a tracked palm, with
/// points or frames on their links as virtual coordinates, all in the world. A joint may name its
/// parent, so that several chains can share a base. f, J and dJ/dq are exact (geometric Jacobian
/// and its product rule); any dim X against dim Q.

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
  /// first); "base": the fixed frame, or the palm where one is tracked.
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

/// A desk stylus: six sensed joints, the first three actuated (turntable, shoulder, elbow), three
/// gimbal joints that are only read. Lengths in m, angles in rad; defaults: our choice, the reach
/// of a small desktop device, held level in front of it at q = 0.
struct StylusDimensions {
  double upper_arm{0.13};
  double forearm{0.13};
  double tip{0.03};  ///< from the gimbal's centre to the stylus tip, along the stylus
  double turntable_lower{-0.9}, turntable_upper{0.9};
  double shoulder_lower{-0.3}, shoulder_upper{1.5};
  double elbow_lower{-2.4}, elbow_upper{-0.4};
  double gimbal_lower{-1.2}, gimbal_upper{1.2};  ///< yaw and pitch; +-pi/2 would be singular
  double roll_lower{-2.6}, roll_upper{2.6};
};

/// The stylus as a chain whose one output is the frame of its tip, "tip". Throws SceneError: a
/// length that is not > 0 or limits out of order.
[[nodiscard]] SerialChainParameters stylus_chain(const StylusDimensions& dimensions);

}  // namespace haptic::core
