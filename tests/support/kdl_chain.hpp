#pragma once
/// The same serial chain for KDL, an independent implementation.

#include <cmath>
#include <kdl/chain.hpp>

#include "haptic/core/model/serial_chain.hpp"

namespace haptic::test {

[[nodiscard]] inline KDL::Frame kdl(const core::Pose3& pose) {
  const core::UnitQuaternion& q = pose.orientation;
  const double n = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {KDL::Rotation::Quaternion(q.x / n, q.y / n, q.z / n, q.w / n),
          KDL::Vector(pose.position.x, pose.position.y, pose.position.z)};
}

/// Joints in a row and the offset of the first output.
[[nodiscard]] inline KDL::Chain kdl(const core::SerialChainParameters& chain) {
  KDL::Chain out;
  for (const core::ChainJoint& joint : chain.joints) {
    out.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl(joint.origin)));
    const KDL::Vector axis(joint.axis.x, joint.axis.y, joint.axis.z);
    const auto kind =
        joint.kind == core::JointKind::kRevolute ? KDL::Joint::RotAxis : KDL::Joint::TransAxis;
    out.addSegment(KDL::Segment(KDL::Joint(KDL::Vector::Zero(), axis, kind)));
  }
  out.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl(chain.outputs.front().offset)));
  return out;
}

}  // namespace haptic::test
