#pragma once
/// Who may take a device from whom (proto/README.md#a-session): only a higher priority preempts.

#include <cstdint>

namespace haptic::server {

/// Numbers of haptic.v1.Priority. kPrimary is what a client has that asks for nothing.
enum class Priority : std::uint8_t { kTest = 1, kPrimary = 2, kOperator = 3 };

[[nodiscard]] constexpr const char* name(Priority priority) noexcept {
  if (priority == Priority::kTest) return "test";
  return priority == Priority::kPrimary ? "primary" : "operator";
}

}  // namespace haptic::server
