#pragma once
/// The tracker of a device: which DoFs are its, and how old its pose may become.

#include <optional>
#include <string>

#include "haptic/core/tick/pipeline.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"

namespace haptic::server {

struct TrackerRead {
  core::TrackerSettings settings{};
  std::optional<core::Duration> fresh_end{};  ///< as given in the scene
};

/// `kinematics` nullptr: not known. Reports one without a tracked palm; the answer is then empty.
[[nodiscard]] std::optional<TrackerRead> read_tracker(v1::StalenessScene& message,
                                                      const std::string& path,
                                                      const core::Kinematics* kinematics,
                                                      Problems& problems);

}  // namespace haptic::server
