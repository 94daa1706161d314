#pragma once
/// What a scene says of the daemon itself: addresses, loop, recording.

#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"
#include "server/scene/scene.hpp"

namespace haptic::server {

/// Each reads its message and fills in the defaults; what is wrong goes to
/// `problems`. Relative files are relative to `folder`.
[[nodiscard]] ServerScene read_server(v1::ServerScene& message, const std::filesystem::path& folder,
                                      Problems& problems);
[[nodiscard]] LoopScene read_loop(v1::LoopScene& message, Problems& problems);
[[nodiscard]] RecordScene read_record(v1::RecordScene& message, Problems& problems);

}  // namespace haptic::server
