#include "call.hpp"

#include <map>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace haptic::client {

namespace {

ErrorReason reason_of(grpc::StatusCode code) {
  using grpc::StatusCode;
  static const std::map<StatusCode, ErrorReason> kReasons{
      {StatusCode::UNAVAILABLE, ErrorReason::kUnreachable},
      {StatusCode::DEADLINE_EXCEEDED, ErrorReason::kTimeout},
      {StatusCode::NOT_FOUND, ErrorReason::kNoSuchDevice},
      {StatusCode::ALREADY_EXISTS, ErrorReason::kLeaseHeld},
      {StatusCode::INVALID_ARGUMENT, ErrorReason::kInvalidArgument},
      {StatusCode::FAILED_PRECONDITION, ErrorReason::kNotReady},
      {StatusCode::RESOURCE_EXHAUSTED, ErrorReason::kNotReady},  // all sessions are taken
      {StatusCode::PERMISSION_DENIED, ErrorReason::kPermissionDenied},
      {StatusCode::ABORTED, ErrorReason::kClosed},
      {StatusCode::CANCELLED, ErrorReason::kClosed},
      {StatusCode::OK, ErrorReason::kClosed}};
  const auto found = kReasons.find(code);
  return found != kReasons.end() ? found->second : ErrorReason::kProtocol;
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
