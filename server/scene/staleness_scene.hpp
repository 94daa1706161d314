#pragma once
/// How old what a client streams may become: the same three fields for proxies and for a tracker's poses.

#include <google/protobuf/message.h>

#include <optional>
#include <string>

#include "haptic/core/safety/staleness.hpp"
#include "server/scene/problems.hpp"

namespace haptic::server {

struct StalenessRead {
  core::StalenessLimits limits{};
  std::optional<core::Duration> fresh_end{};  ///< as given in the scene
};

/// Reads fresh_end, hold_end and fade_end of a message whose path is `path`, and fills in their
/// defaults.
[[nodiscard]] StalenessRead read_staleness(google::protobuf::Message& message,
                                           const std::string& path, Problems& problems);

}  // namespace haptic::server
