#pragma once
/// The one place where a refusal becomes a grpc::Status (private to server/rpc).

#include <grpcpp/support/status.h>

#include "server/front/refusals.hpp"

namespace haptic::server {

/// Canonical code, message, ErrorInfo {reason, domain "hapticd"}, and a BadRequest if a field is
/// off.
[[nodiscard]] grpc::Status to_status(const Refusal& refusal);

}  // namespace haptic::server
