#include "call.hpp"

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace haptic::client {

namespace {

/// No table: a session that ends within exit() asks after statics are destroyed.
ErrorReason reason_of(grpc::StatusCode code) {
  using grpc::StatusCode;
  switch (code) {
    case StatusCode::UNAVAILABLE:
      return ErrorReason::kUnreachable;
    case StatusCode::DEADLINE_EXCEEDED:
      return ErrorReason::kTimeout;
    case StatusCode::NOT_FOUND:
      return ErrorReason::kNoSuchDevice;
    case StatusCode::ALREADY_EXISTS:
      return ErrorReason::kLeaseHeld;
    case StatusCode::INVALID_ARGUMENT:
      return ErrorReason::kInvalidArgument;
    case StatusCode::FAILED_PRECONDITION:
    case StatusCode::RESOURCE_EXHAUSTED:  // all sessions are taken
      return ErrorReason::kNotReady;
    case StatusCode::PERMISSION_DENIED:
      return ErrorReason::kPermissionDenied;
    case StatusCode::OK:
    case StatusCode::ABORTED:
    case StatusCode::CANCELLED:
      return ErrorReason::kClosed;
    default:
      return ErrorReason::kProtocol;
  }
}

std::string server_reason(const grpc::Status& status) {
  google::rpc::Status details;
  if (!details.ParseFromString(status.error_details())) return {};
  for (const auto& detail : details.details()) {
    google::rpc::ErrorInfo info;
    if (detail.UnpackTo(&info)) return info.reason();
  }
  return {};
}

}  // namespace

ClientError to_error(const grpc::Status& status) {
  const std::string message =
      status.error_message().empty() ? "the stream ended" : status.error_message();
  return {reason_of(status.error_code()), message, server_reason(status)};
}

void check(const grpc::Status& status) {
  if (!status.ok()) throw to_error(status);
}

}  // namespace haptic::client
