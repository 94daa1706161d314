#include <algorithm>
#include <numbers>
#include <utility>

#include "finger_block.hpp"
#include "haptic/core/error.hpp"
#include "tree_map.hpp"

namespace haptic::core {

namespace {

/// Bodies of the tree: the palm, then proximal and middle phalanx of each finger.
constexpr int kPalm = 0;

int body(std::size_t finger, Phalanx phalanx) noexcept {
  return 1 + 2 * static_cast<int>(finger) + (phalanx == Phalanx::kMiddle ? 1 : 0);
}

/// Flexion turns a phalanx from dorsal to palmar, from +y to -y: about -z.
const Eigen::Vector3d kFlexion = -Eigen::Vector3d::UnitZ();

void append_phalanges(const MountedFinger& mounted, std::vector<TreeJoint>& joints) {
  const Pose3& mount = mounted.mount;
  require_pose(mount, "finger " + mounted.finger.name + ".mount");
  const int proximal = static_cast<int>(joints.size());
  joints.push_back({TreeJoint::Motion::kRevolute, kPalm, quaternion(mount.orientation),
                    vector(mount.position), kFlexion});
  const Eigen::Vector3d pip(mounted.finger.dimensions.proximal_phalanx, 0.0, 0.0);
  joints.push_back(
      {TreeJoint::Motion::kRevolute, proximal, Eigen::Quaterniond::Identity(), pip, kFlexion});
}

TreeOutput tree_output(const PhalanxOutput& output, const std::vector<FingerBlock>& fingers,
                       const std::vector<TreeOutput>& others) {
  const std::string where = "output " + output.name;
  require_new_output(output.name, output.offset, others);
  int on = kPalm;
  if (!output.finger.empty()) {
    const auto at = std::find_if(fingers.begin(), fingers.end(), [&](const FingerBlock& finger) {
      return finger.name == output.finger;
    });
    if (at == fingers.end()) {
      throw SceneError(where + ".finger = " + output.finger + ": must be one of the hand's");
    }
    on = body(static_cast<std::size_t>(at - fingers.begin()), output.phalanx);
  }
  return {output.name, on, output.kind, vector(output.offset.position),
          quaternion(output.offset.orientation)};
}

}  // namespace

std::unique_ptr<Kinematics> make_tracked_hand(const TrackedHandParameters& parameters) {
  const std::size_t n_q = 6 + 2 * parameters.fingers.size();
  if (parameters.fingers.empty() || n_q > static_cast<std::size_t>(kMaxQ)) {
    throw SceneError("tracked hand with " + std::to_string(parameters.fingers.size()) +
                     " fingers: must have 1 to " + std::to_string((kMaxQ - 6) / 2));
  }
  std::vector<DofSpec> dofs;
  append_palm(parameters.palm, dofs);
  std::vector<TreeJoint> joints{{TreeJoint::Motion::kFree}};
  std::vector<FingerBlock> fingers;
  std::vector<TreeDrive> drives;
  for (const MountedFinger& mounted : parameters.fingers) {
    fingers.push_back(finger_block(mounted.finger, fingers));
    drives.push_back({static_cast<int>(dofs.size()), fingers.back().kinematics});
    append_finger(fingers.back(), dofs);
    append_phalanges(mounted, joints);
  }
  std::vector<TreeOutput> outputs;
  for (const PhalanxOutput& output : parameters.outputs) {
    outputs.push_back(tree_output(output, fingers, outputs));
  }
  constexpr int kRotation = 3;
  return std::make_unique<TreeMap>(RigidTree(std::move(joints), std::move(outputs)),
                                   std::move(dofs), std::move(drives), kRotation);
}

}  // namespace haptic::core
