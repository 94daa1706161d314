#pragma once
/// What a scene says of TLS.

#include <filesystem>

#include "haptic/v1/scene.pb.h"
#include "server/crossing/tls_config.hpp"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// Relative files are relative to `folder`, and get their full path in the message. What they hold is
/// checked where they are used.
[[nodiscard]] TlsConfig read_tls(v1::TlsScene& message, const std::filesystem::path& folder,
                                 Problems& problems);

}  // namespace haptic::server
