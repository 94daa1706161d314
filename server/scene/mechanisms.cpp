// Kinematics made of named links: hands, styli, serial chains.
#include <cmath>
#include <set>

#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/model/serial_chain.hpp"
#include "haptic/core/model/stylus.hpp"
#include "server/scene/parts.hpp"
#include "server/scene/reader.hpp"

namespace haptic::server {
namespace {

/// Longest name that becomes part of a DoF's or coordinate's name.
constexpr std::size_t kLongestPartName = 24;

/// The list `field` as x, y, z; `fallback` if it is empty. Zeros if it is wrong.
core::Point3 read_triple(const FieldReader& reader, const char* field,
                         const core::Point3& fallback) {
  const std::vector<double> values =
      reader.list({field, Allowed::kFinite, 3, "axis"},
                  std::vector<double>{fallback.x, fallback.y, fallback.z});
  return values.size() == 3 ? core::Point3{values[0], values[1], values[2]} : core::Point3{};
}

core::Pose3 read_point(v1::PointScene& message, const std::string& path, Problems& problems) {
  return {read_triple(FieldReader(message, path, problems), "position_m", {}), {}};
}

core::Pose3 read_pose(v1::PoseScene& message, const std::string& path, Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::Pose3 pose;
  pose.position = read_triple(reader, "position_m", {});
  const std::vector<double> q = reader.list({"orientation", Allowed::kFinite, 4, "part x, y, z, w"},
                                            std::vector<double>{0.0, 0.0, 0.0, 1.0});
  if (q.size() != 4) return pose;
  pose.orientation = {q[0], q[1], q[2], q[3]};
  if (!(std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3])) > 1e-6)) {
    reader.wrong("orientation", decimal(q), "must be a quaternion other than zero");
  }
  return pose;
}

core::TrackedPalm read_palm(v1::PalmScene& message, const std::string& path, Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::TrackedPalm palm;
  if (message.name().empty()) message.set_name(palm.name);
  palm.name = message.name();
  std::set<std::string> names;
  reader.entry_name(kLongestPartName, names);
  reader.numbers({{"position_lower_m", &palm.position_lower, Allowed::kFinite},
                  {"position_upper_m", &palm.position_upper, Allowed::kFinite}});
  if (palm.position_upper <= palm.position_lower) {
    reader.wrong("position_upper_m", decimal(palm.position_upper),
                 "must be above its lower limit, " + decimal(palm.position_lower));
  }
  return palm;
}

/// Kind of an output, and its place on its body.
struct OutputPose {
  core::OutputKind kind{core::OutputKind::kPoint};
  core::Pose3 offset{};
};

/// Reads the oneof `what` of a message: a point or a frame.
template <typename Message>
OutputPose read_output(Message& message, const std::string& path, Problems& problems) {
  if (message.has_point()) {
    return {core::OutputKind::kPoint,
            read_point(*message.mutable_point(), path + ".point", problems)};
  }
  if (message.has_frame()) {
    return {core::OutputKind::kFrame,
            read_pose(*message.mutable_frame(), path + ".frame", problems)};
  }
  problems.missing(path + ".what", "one of point, frame");
  return {};
}

/// A finger of either hand: their messages begin alike.
template <typename Finger>
core::HandFinger read_finger(Finger& message, const std::string& path, std::set<std::string>& names,
                             Problems& problems) {
  const FieldReader reader(message, path, problems);
  reader.entry_name(kLongestPartName, names);
  double size = 1.0;
  reader.numbers({{"size", &size, Allowed::kPositive}});
  const core::FingerDimensions dimensions =
      read_dimensions(*message.mutable_dimensions(), path + ".dimensions", problems);
  return {message.name(), core::scaled(dimensions, size)};
}

core::PhalanxOutput read_phalanx_output(v1::TrackedHandScene::Output& message,
                                        const std::string& path, std::set<std::string>& names,
                                        Problems& problems) {
  const FieldReader reader(message, path, problems);
  reader.entry_name(kLongestPartName, names);
  if (message.phalanx().empty()) message.set_phalanx("middle");
  const bool proximal = message.phalanx() == "proximal";
  if (!proximal && message.phalanx() != "middle") {
    reader.wrong("phalanx", quoted(message.phalanx()), R"(must be "proximal" or "middle")");
  }
  const OutputPose pose = read_output(message, path, problems);
  return {message.name(), message.finger(),
          proximal ? core::Phalanx::kProximal : core::Phalanx::kMiddle, pose.kind, pose.offset};
}

using Outputs = google::protobuf::RepeatedPtrField<v1::ChainOutputScene>;

std::vector<core::ChainOutput> read_outputs(Outputs& messages, const std::string& path,
                                            Problems& problems) {
  if (messages.empty()) problems.missing(path + ".output", "at least one");
  std::set<std::string> names;
  std::vector<core::ChainOutput> outputs;
  for (int i = 0; i < messages.size(); ++i) {
    v1::ChainOutputScene& message = *messages.Mutable(i);
    const std::string at = path + "." + entry("output", i);
    FieldReader(message, at, problems).entry_name(kLongestPartName, names);
    const OutputPose pose = read_output(message, at, problems);
    outputs.push_back({message.name(), message.link(), pose.kind, pose.offset});
  }
  return outputs;
}

core::ChainJoint read_joint(v1::SerialChainScene::Joint& message, const std::string& path,
                            std::set<std::string>& names, Problems& problems) {
  const FieldReader reader(message, path, problems);
  reader.entry_name(kLongestPartName, names);
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

SharedKinematics read_hand_exoskeleton(v1::HandExoskeletonScene& message, const std::string& path,
                                       Problems& problems) {
  const std::size_t before = problems.count();
  std::set<std::string> names;
  std::vector<core::HandFinger> fingers;
  if (message.finger().empty()) problems.missing(path + ".finger", "1 to 12");
  fingers.reserve(static_cast<std::size_t>(message.finger_size()));
  for (int i = 0; i < message.finger_size(); ++i) {
    fingers.push_back(
        read_finger(*message.mutable_finger(i), path + "." + entry("finger", i), names, problems));
  }
  if (problems.count() > before) return nullptr;
  return made([&] { return core::make_hand_exoskeleton(fingers); }, path, problems);
}

SharedKinematics read_tracked_hand(v1::TrackedHandScene& message, const std::string& path,
                                   Problems& problems) {
  const std::size_t before = problems.count();
  core::TrackedHandParameters hand;
  hand.palm = read_palm(*message.mutable_palm(), path + ".palm", problems);
  if (message.finger().empty()) problems.missing(path + ".finger", "1 to 9");
  std::set<std::string> fingers, outputs;
  for (int i = 0; i < message.finger_size(); ++i) {
    const std::string at = path + "." + entry("finger", i);
    auto& finger = *message.mutable_finger(i);
    core::MountedFinger mounted;
    mounted.finger = read_finger(finger, at, fingers, problems);
    mounted.mount = read_pose(*finger.mutable_mount(), at + ".mount", problems);
    hand.fingers.push_back(mounted);
  }
  if (message.output().empty()) problems.missing(path + ".output", "at least one");
  for (int i = 0; i < message.output_size(); ++i) {
    const std::string at = path + "." + entry("output", i);
    hand.outputs.push_back(read_phalanx_output(*message.mutable_output(i), at, outputs, problems));
  }
  if (problems.count() > before) return nullptr;
  return made([&] { return core::make_tracked_hand(hand); }, path, problems);
}

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
