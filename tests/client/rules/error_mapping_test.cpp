/// Which reason a status of gRPC becomes.

#include "error_mapping.hpp"

#include <gtest/gtest.h>

#include <utility>

namespace haptic::client {
namespace {

TEST(ErrorMapping, EachStatusHasItsReason) {
  using grpc::StatusCode;
  const std::pair<StatusCode, ErrorReason> table[] = {
      {StatusCode::UNAVAILABLE, ErrorReason::kUnreachable},
      {StatusCode::DEADLINE_EXCEEDED, ErrorReason::kTimeout},
      {StatusCode::NOT_FOUND, ErrorReason::kNoSuchDevice},
      {StatusCode::ALREADY_EXISTS, ErrorReason::kLeaseHeld},
      {StatusCode::INVALID_ARGUMENT, ErrorReason::kInvalidArgument},
      {StatusCode::FAILED_PRECONDITION, ErrorReason::kNotReady},
      {StatusCode::RESOURCE_EXHAUSTED, ErrorReason::kNotReady},
      {StatusCode::PERMISSION_DENIED, ErrorReason::kPermissionDenied},
      {StatusCode::ABORTED, ErrorReason::kClosed},
      {StatusCode::CANCELLED, ErrorReason::kClosed},
      {StatusCode::OK, ErrorReason::kClosed},
      {StatusCode::UNIMPLEMENTED, ErrorReason::kProtocol},
      {StatusCode::INTERNAL, ErrorReason::kProtocol}};
  for (const auto& [code, reason] : table) {
    const ClientError error = to_error({code, "why"});
    EXPECT_EQ(error.reason(), reason) << code;
    EXPECT_STREQ(error.what(), "why");
    EXPECT_EQ(error.server_reason(), "");
  }
}

}  // namespace
}  // namespace haptic::client
