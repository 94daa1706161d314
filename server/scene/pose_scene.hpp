#pragma once
/// Poses, palms and outputs, as chains and hands have them.

#include "haptic/core/model/rigid_pose.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/scene/field_reader.hpp"

namespace haptic::server {

/// Longest name of what becomes part of a DoF's or coordinate's name.
inline constexpr std::size_t kLongestPartName = 24;

/// Each fills in the defaults of its message, whose path is `path`.
[[nodiscard]] core::Pose3 read_pose(v1::PoseScene& message, const std::string& path,
                                    Problems& problems);
[[nodiscard]] core::Pose3 read_point(v1::PointScene& message, const std::string& path,
                                     Problems& problems);
[[nodiscard]] core::TrackedPalm read_palm(v1::PalmScene& message, const std::string& path,
                                          Problems& problems);
/// The list `field` as x, y, z; `fallback` where the list is empty. Zeros where it is wrong.
[[nodiscard]] core::Point3 read_triple(const FieldReader& reader, const char* field,
                                       const core::Point3& fallback);

/// What an output contributes: its kind, and where it stands on its body.
struct OutputPose {
  core::OutputKind kind{core::OutputKind::kPoint};
  core::Pose3 offset{};
};

/// Of a message with the oneof `what` of a point or a frame.
template <typename Message>
[[nodiscard]] OutputPose read_output(Message& message, const std::string& path,
                                     Problems& problems) {
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

}  // namespace haptic::server
