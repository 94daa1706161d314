#pragma once
/// Refusals and messages as gRPC takes them (private to server/front/grpc).

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/status.h>

#include <optional>

#include "server/crossing/outcome.hpp"
#include "server/front/service/state_frame.hpp"

namespace haptic::server {

/// OK without a refusal; else see rich_status().
[[nodiscard]] grpc::Status to_status(const std::optional<Refusal>& refusal);

/// `message` without a copy of what streams share.
[[nodiscard]] grpc::ByteBuffer to_buffer(Outgoing message);

}  // namespace haptic::server
