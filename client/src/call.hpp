#pragma once
/// Calls of the service that wait for their answer, and how their errors become ClientError.

#include <grpcpp/grpcpp.h>

#include <chrono>

#include "haptic/client/error.hpp"
#include "haptic/v1/haptic_service.grpc.pb.h"

namespace haptic::client {

/// The error that the status and the google.rpc details in it say.
[[nodiscard]] ClientError to_error(const grpc::Status& status);
/// Throws if the call failed.
void check(const grpc::Status& status);

using Stub = v1::HapticService::Stub;

/// The answer to `request`. Throws ClientError if the server refuses, or is silent for `timeout`.
template <typename Request, typename Response>
Response call(Stub& stub,
              grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
              const Request& request, std::chrono::milliseconds timeout) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + timeout);
  Response response;
  check((stub.*method)(&context, request, &response));
  return response;
}

}  // namespace haptic::client
