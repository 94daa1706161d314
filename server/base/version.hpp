#pragma once

namespace haptic::server {

/// The project's version.
[[nodiscard]] const char* version() noexcept;

}  // namespace haptic::server
