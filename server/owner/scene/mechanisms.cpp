// Kinematics made of named links: hands, styli, serial chains.
#include <set>

#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/model/serial_chain.hpp"
#include "haptic/core/model/stylus.hpp"
#include "server/owner/scene/parts.hpp"

namespace haptic::server {
namespace {

/// Longest name that becomes part of a DoF's or coordinate's name.
constexpr std::size_t kLongestPartName = 24;

/// The list `field` as x, y, z; `fallback` if it is empty. Zeros if it is wrong.
core::Point3 read_triple(const Fields& part, const char* field, const core::Point3& fallback) {
  const auto values = part.list({field, Allowed::kFinite, 3, "axis"},
                                Eigen::Vector3d(fallback.x, fallback.y, fallback.z));
  return values.size() == 3 ? core::Point3{values[0], values[1], values[2]} : core::Point3{};
}

core::Pose3 read_pose(const Part<v1::PoseScene>& part) {
  core::Pose3 pose;
  pose.position = read_triple(part, "position_m", {});
  const auto q = part.list({"orientation", Allowed::kFinite, 4, "part x, y, z, w"},
                           Eigen::Vector4d(0.0, 0.0, 0.0, 1.0));
  if (q.size() != 4) return pose;
  pose.orientation = {q[0], q[1], q[2], q[3]};
  if (!(q.norm() > 1e-6)) {
    part.wrong("orientation", decimal(q), "must be a quaternion other than zero");
  }
  return pose;
}

core::TrackedPalm read_palm(const Part<v1::PalmScene>& part) {
  core::TrackedPalm palm;
  if (part->name().empty()) part->set_name(palm.name);
  palm.name = part->name();
  std::set<std::string> names;
  part.entry_name(kLongestPartName, names);
  part.numbers({{"position_lower_m", &palm.position_lower, Allowed::kFinite},
                {"position_upper_m", &palm.position_upper, Allowed::kFinite}});
  part.above("position_upper_m", palm.position_upper, palm.position_lower);
  return palm;
}

/// Kind of an output, and its place on its body.
struct OutputPose {
  core::OutputKind kind{core::OutputKind::kPoint};
  core::Pose3 offset{};
};

/// Reads the oneof `what` of a message: a point or a frame.
OutputPose read_output(const Fields& part) {
  const std::string what = part.choice("what");
  if (what == "point") {
    return {core::OutputKind::kPoint,
            {read_triple(part.part<v1::PointScene>(what), "position_m", {}), {}}};
  }
  if (what == "frame") {
    return {core::OutputKind::kFrame, read_pose(part.part<v1::PoseScene>(what))};
  }
  return {};
}

/// A finger of either hand: their messages begin alike.
template <typename Finger>
core::HandFinger read_finger(const Part<Finger>& part, std::set<std::string>& names) {
  part.entry_name(kLongestPartName, names);
  double size = 1.0;
  part.numbers({{"size", &size, Allowed::kPositive}});
  const core::FingerDimensions dimensions =
      read_dimensions(part.template part<v1::FingerExoskeletonScene>("dimensions"));
  return {part->name(), core::scaled(dimensions, size)};
}

core::PhalanxOutput read_phalanx_output(const Part<v1::TrackedHandScene::Output>& part,
                                        std::set<std::string>& names) {
  part.entry_name(kLongestPartName, names);
  const bool middle = part.word("phalanx", {"proximal", "middle"}, "middle") == 1;
  const OutputPose pose = read_output(part);
  return {part->name(), part->finger(), middle ? core::Phalanx::kMiddle : core::Phalanx::kProximal,
          pose.kind, pose.offset};
}

/// The list `output` of a stylus or a chain.
std::vector<core::ChainOutput> read_outputs(const Fields& mechanism) {
  const auto parts = mechanism.parts<v1::ChainOutputScene>("output");
  if (parts.empty()) mechanism.missing("output", "at least one");
  std::set<std::string> names;
  std::vector<core::ChainOutput> outputs;
  for (const auto& part : parts) {
    part.entry_name(kLongestPartName, names);
    const OutputPose pose = read_output(part);
    outputs.push_back({part->name(), part->link(), pose.kind, pose.offset});
  }
  return outputs;
}

core::ChainJoint read_joint(const Part<v1::SerialChainScene::Joint>& part,
                            std::set<std::string>& names) {
  part.entry_name(kLongestPartName, names);
  const bool prismatic = part.word("kind", {"revolute", "prismatic"}, "revolute") == 1;
  core::ChainJoint joint;
  joint.name = part->name();
  joint.kind = prismatic ? core::JointKind::kPrismatic : core::JointKind::kRevolute;
  joint.actuated = part->actuated();
  joint.parent = part->parent();
  joint.origin = read_pose(part.part<v1::PoseScene>("origin"));
  joint.axis = read_triple(part, "axis", joint.axis);
  joint.lower = part->lower();
  joint.upper = part->upper();
  if (!(joint.upper > joint.lower)) {
    part.wrong("upper", decimal(joint.upper), "must be above lower, " + decimal(joint.lower));
  }
  return joint;
}

}  // namespace

SharedKinematics read_hand_exoskeleton(const Part<v1::HandExoskeletonScene>& part) {
  std::set<std::string> names;
  std::vector<core::HandFinger> fingers;
  if (part->finger().empty()) part.missing("finger", "1 to 12");
  for (const auto& finger : part.parts<v1::HandExoskeletonScene::Finger>("finger")) {
    fingers.push_back(read_finger(finger, names));
  }
  return made(part, [&] { return core::make_hand_exoskeleton(fingers); });
}

SharedKinematics read_tracked_hand(const Part<v1::TrackedHandScene>& part) {
  core::TrackedHandParameters hand;
  hand.palm = read_palm(part.part<v1::PalmScene>("palm"));
  if (part->finger().empty()) part.missing("finger", "1 to 9");
  std::set<std::string> fingers, outputs;
  for (const auto& finger : part.parts<v1::TrackedHandScene::Finger>("finger")) {
    core::MountedFinger mounted;
    mounted.finger = read_finger(finger, fingers);
    mounted.mount = read_pose(finger.part<v1::PoseScene>("mount"));
    hand.fingers.push_back(mounted);
  }
  if (part->output().empty()) part.missing("output", "at least one");
  for (const auto& output : part.parts<v1::TrackedHandScene::Output>("output")) {
    hand.outputs.push_back(read_phalanx_output(output, outputs));
  }
  return made(part, [&] { return core::make_tracked_hand(hand); });
}

SharedKinematics read_stylus(const Part<v1::StylusScene>& part) {
  core::StylusDimensions d;
  part.numbers({
      {"upper_arm_m", &d.upper_arm, Allowed::kPositive},
      {"forearm_m", &d.forearm, Allowed::kPositive},
      {"turntable_lower_rad", &d.turntable_lower, Allowed::kFinite},
      {"turntable_upper_rad", &d.turntable_upper, Allowed::kFinite},
      {"shoulder_lower_rad", &d.shoulder_lower, Allowed::kFinite},
      {"shoulder_upper_rad", &d.shoulder_upper, Allowed::kFinite},
      {"elbow_lower_rad", &d.elbow_lower, Allowed::kFinite},
      {"elbow_upper_rad", &d.elbow_upper, Allowed::kFinite},
      {"gimbal_lower_rad", &d.gimbal_lower, Allowed::kFinite},
      {"gimbal_upper_rad", &d.gimbal_upper, Allowed::kFinite},
      {"roll_lower_rad", &d.roll_lower, Allowed::kFinite},
      {"roll_upper_rad", &d.roll_upper, Allowed::kFinite},
  });
  const auto outputs = read_outputs(part);
  return made(part, [&] { return core::make_stylus(d, outputs); });
}

SharedKinematics read_serial_chain(const Part<v1::SerialChainScene>& part) {
  core::SerialChainParameters chain;
  if (part->has_palm()) chain.palm = read_palm(part.part<v1::PalmScene>("palm"));
  if (part->joint().empty()) part.missing("joint", "at least one");
  std::set<std::string> names;
  for (const auto& joint : part.parts<v1::SerialChainScene::Joint>("joint")) {
    chain.joints.push_back(read_joint(joint, names));
  }
  chain.outputs = read_outputs(part);
  return made(part, [&] { return core::make_serial_chain(chain); });
}

}  // namespace haptic::server
