#pragma once
/// The one place where a refusal becomes a grpc::Status (private to server/rpc).

#include <grpcpp/support/status.h>

#include <optional>
#include <string>

#include "server/session/refusal.hpp"

namespace haptic::server {

/// Canonical code, message, ErrorInfo {reason, domain "hapticd"}, and a BadRequest where a field is
/// off.
[[nodiscard]] grpc::Status to_status(const Refusal& refusal);

/// kInvalid, of one field: "name = value: what is allowed".
[[nodiscard]] Refusal invalid_field(std::string field, const std::string& rest);

/// The largest message of the protocol, 72 coordinates with velocities and planes, has a few KB.
constexpr std::size_t kLargestMessage = 64 * 1024;
/// RESOURCE_EXHAUSTED, where a message of `bytes` is larger than that.
[[nodiscard]] std::optional<Refusal> too_large(std::size_t bytes);

/// Text of a client, fit for logs, terminals and other clients: control characters become '?', at
/// most `longest` bytes are kept (never half a UTF-8 character).
[[nodiscard]] std::string sanitised(const std::string& text, std::size_t longest);

}  // namespace haptic::server
