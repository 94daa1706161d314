#pragma once
/// A call of the service that waits for its answer.

#include <grpcpp/grpcpp.h>

#include <chrono>

#include "error_mapping.hpp"
#include "haptic/v1/haptic_service.grpc.pb.h"

namespace haptic::client {

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
