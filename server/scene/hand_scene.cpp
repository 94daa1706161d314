#include "haptic/core/model/hand_exoskeleton.hpp"

#include "server/scene/entry_name.hpp"
#include "server/scene/field_reader.hpp"
#include "server/scene/finger_scene.hpp"
#include "server/scene/kinematics_scene.hpp"
#include "server/scene/pose_scene.hpp"

namespace haptic::server {
namespace {

/// Of either hand: their fingers begin alike.
template <typename Finger>
core::HandFinger read_finger(Finger& message, const std::string& path, std::set<std::string>& names,
                             Problems& problems) {
  const FieldReader reader(message, path, problems);
  check_entry_name(reader, message.name(), kLongestPartName, names);
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
  check_entry_name(reader, message.name(), kLongestPartName, names);
  if (message.phalanx().empty()) message.set_phalanx("middle");
  const bool proximal = message.phalanx() == "proximal";
  if (!proximal && message.phalanx() != "middle") {
    reader.wrong("phalanx", quoted(message.phalanx()), R"(must be "proximal" or "middle")");
  }
  const OutputPose pose = read_output(message, path, problems);
  return {message.name(), message.finger(),
          proximal ? core::Phalanx::kProximal : core::Phalanx::kMiddle, pose.kind, pose.offset};
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

}  // namespace haptic::server
