#pragma once
/// grpc::Status, with the google.rpc details in it, -> ClientError.

#include <grpcpp/support/status.h>

#include "haptic/client/error.hpp"

namespace haptic::client {

[[nodiscard]] ClientError to_error(const grpc::Status& status);
/// Throws where the call failed.
void check(const grpc::Status& status);

}  // namespace haptic::client
