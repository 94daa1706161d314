/// Which reason of the library each reason of proto/README.md#errors becomes, by its status there.

#include "call.hpp"

#include <gtest/gtest.h>

#include <map>

#include "tests/proto/markdown.hpp"

namespace haptic::client {
namespace {

using grpc::StatusCode;

const std::map<std::string, StatusCode> kStatuses{
    {"INVALID_ARGUMENT", StatusCode::INVALID_ARGUMENT},
    {"NOT_FOUND", StatusCode::NOT_FOUND},
    {"ALREADY_EXISTS", StatusCode::ALREADY_EXISTS},
    {"RESOURCE_EXHAUSTED", StatusCode::RESOURCE_EXHAUSTED},
    {"PERMISSION_DENIED", StatusCode::PERMISSION_DENIED},
    {"ABORTED", StatusCode::ABORTED},
    {"FAILED_PRECONDITION", StatusCode::FAILED_PRECONDITION},
    {"UNAVAILABLE", StatusCode::UNAVAILABLE}};

/// Meaning of a reason to a program; what is not listed can be asked for again later.
const std::map<std::string, ErrorReason> kMeanings{
    {"INVALID_ARGUMENT", ErrorReason::kInvalidArgument},
    {"PROTOCOL", ErrorReason::kInvalidArgument},
    {"NO_SUCH_DEVICE", ErrorReason::kNoSuchDevice},
    {"LEASE_HELD", ErrorReason::kLeaseHeld},
    {"TRACKER_HELD", ErrorReason::kLeaseHeld},
    {"PRIORITY_DENIED", ErrorReason::kPermissionDenied},
    {"RIGHTS", ErrorReason::kPermissionDenied},
    {"NOT_CONTROLLER", ErrorReason::kPermissionDenied},
    {"GUARD_REQUIRED", ErrorReason::kPermissionDenied},
    {"STOPPED_LOCALLY", ErrorReason::kPermissionDenied},
    {"RESUMED", ErrorReason::kClosed},
    {"SESSION_ENDED", ErrorReason::kClosed},
    {"NO_ANSWER", ErrorReason::kUnreachable},
    {"CLOSING", ErrorReason::kUnreachable}};

TEST(ErrorMapping, EachReasonKeepsItsMeaning) {
  const std::string page = test::read_text(std::string(HAPTIC_SOURCE_DIR) + "/proto/README.md");
  for (const auto& row : test::markdown_table(page, "reason")) {
    const auto meant = kMeanings.find(test::unquoted(row.at(0)));
    const ClientError error = to_error({kStatuses.at(row.at(1)), "why"});
    EXPECT_EQ(error.reason(), meant == kMeanings.end() ? ErrorReason::kNotReady : meant->second)
        << row.at(0);
    EXPECT_STREQ(error.what(), "why");
  }
}

TEST(ErrorMapping, GrpcsOwnErrorsHaveReasons) {
  EXPECT_EQ(to_error({StatusCode::DEADLINE_EXCEEDED, ""}).reason(), ErrorReason::kTimeout);
  EXPECT_EQ(to_error({StatusCode::CANCELLED, ""}).reason(), ErrorReason::kClosed);
  EXPECT_EQ(to_error(grpc::Status::OK).reason(), ErrorReason::kClosed) << "the stream's end";
  EXPECT_EQ(to_error({StatusCode::UNIMPLEMENTED, ""}).reason(), ErrorReason::kProtocol);
}

}  // namespace
}  // namespace haptic::client
