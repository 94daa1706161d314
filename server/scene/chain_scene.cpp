#include "haptic/core/model/serial_chain.hpp"
#include "haptic/core/model/stylus.hpp"
#include "server/scene/entry_name.hpp"
#include "server/scene/field_reader.hpp"
#include "server/scene/kinematics_scene.hpp"
#include "server/scene/pose_scene.hpp"

namespace haptic::server {
namespace {

using Outputs = google::protobuf::RepeatedPtrField<v1::ChainOutputScene>;

std::vector<core::ChainOutput> read_outputs(Outputs& messages, const std::string& path,
                                            Problems& problems) {
  if (messages.empty()) problems.missing(path + ".output", "at least one");
  std::set<std::string> names;
  std::vector<core::ChainOutput> outputs;
  for (int i = 0; i < messages.size(); ++i) {
    v1::ChainOutputScene& message = *messages.Mutable(i);
    const std::string at = path + "." + entry("output", i);
    check_entry_name(FieldReader(message, at, problems), message.name(), kLongestPartName, names);
    const OutputPose pose = read_output(message, at, problems);
    outputs.push_back({message.name(), message.link(), pose.kind, pose.offset});
  }
  return outputs;
}

core::ChainJoint read_joint(v1::SerialChainScene::Joint& message, const std::string& path,
                            std::set<std::string>& names, Problems& problems) {
  const FieldReader reader(message, path, problems);
  check_entry_name(reader, message.name(), kLongestPartName, names);
  if (message.kind().empty()) message.set_kind("revolute");
  const bool prismatic = message.kind() == "prismatic";
  if (!prismatic && message.kind() != "revolute") {
    reader.wrong("kind", quoted(message.kind()), R"(must be "revolute" or "prismatic")");
  }
  core::ChainJoint joint;
  joint.name = message.name();
  joint.kind = prismatic ? core::JointKind::kPrismatic : core::JointKind::kRevolute;
  joint.actuated = message.actuated();
  joint.parent = message.parent();
  joint.origin = read_pose(*message.mutable_origin(), path + ".origin", problems);
  joint.axis = read_triple(reader, "axis", joint.axis);
  joint.lower = message.lower();
  joint.upper = message.upper();
  if (!(joint.upper > joint.lower)) {
    reader.wrong("upper", decimal(joint.upper), "must be above lower, " + decimal(joint.lower));
  }
  return joint;
}

}  // namespace

SharedKinematics read_stylus(v1::StylusScene& message, const std::string& path,
                             Problems& problems) {
  const std::size_t before = problems.count();
  core::StylusDimensions d;
  const FieldReader reader(message, path, problems);
  reader.numbers({
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
  const auto outputs = read_outputs(*message.mutable_output(), path, problems);
  if (problems.count() > before) return nullptr;
  return made([&] { return core::make_stylus(d, outputs); }, path, problems);
}

SharedKinematics read_serial_chain(v1::SerialChainScene& message, const std::string& path,
                                   Problems& problems) {
  const std::size_t before = problems.count();
  core::SerialChainParameters chain;
  if (message.has_palm()) {
    chain.palm = read_palm(*message.mutable_palm(), path + ".palm", problems);
  }
  if (message.joint().empty()) problems.missing(path + ".joint", "at least one");
  std::set<std::string> names;
  for (int i = 0; i < message.joint_size(); ++i) {
    chain.joints.push_back(
        read_joint(*message.mutable_joint(i), path + "." + entry("joint", i), names, problems));
  }
  chain.outputs = read_outputs(*message.mutable_output(), path, problems);
  if (problems.count() > before) return nullptr;
  return made([&] { return core::make_serial_chain(chain); }, path, problems);
}

}  // namespace haptic::server
