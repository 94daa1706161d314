#pragma once
/// Refusals by the front itself, and texts of clients.

#include <optional>
#include <string>

#include "server/crossing/outcome.hpp"

namespace haptic::server {

/// The largest message of the protocol, 72 coordinates with velocities and planes, has a few KB.
constexpr std::size_t kLargestMessage = 64 * 1024;
/// RESOURCE_EXHAUSTED, if a message of `bytes` is larger than that.
[[nodiscard]] std::optional<Refusal> too_large(std::size_t bytes);

/// `rate_hz` as a stream may ask for it: 0, or 1 up to the loop's.
[[nodiscard]] std::optional<Refusal> check_rate(const char* field, double rate_hz, double loop_hz);

/// PERMISSION_DENIED: this client may only look on.
[[nodiscard]] Refusal observes_only();

/// Text of a client, fit for logs, terminals and other clients: control characters and marks of
/// writing direction become '?', at most `longest` bytes are kept (never half a UTF-8 character).
[[nodiscard]] std::string sanitised(const std::string& text, std::size_t longest);

}  // namespace haptic::server
