#include "error_mapping.hpp"

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace haptic::client {

namespace {

ErrorReason reason_of(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::UNAVAILABLE:
      return ErrorReason::kUnreachable;
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return ErrorReason::kTimeout;
    case grpc::StatusCode::NOT_FOUND:
      return ErrorReason::kNoSuchDevice;
    case grpc::StatusCode::ALREADY_EXISTS:
      return ErrorReason::kLeaseHeld;
    case grpc::StatusCode::INVALID_ARGUMENT:
      return ErrorReason::kInvalidArgument;
    case grpc::StatusCode::FAILED_PRECONDITION:
    case grpc::StatusCode::RESOURCE_EXHAUSTED:  // all sessions are taken
      return ErrorReason::kNotReady;
    case grpc::StatusCode::PERMISSION_DENIED:
      return ErrorReason::kPermissionDenied;
    case grpc::StatusCode::ABORTED:
    case grpc::StatusCode::CANCELLED:
    case grpc::StatusCode::OK:
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
