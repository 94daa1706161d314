#include "server/rpc/status.hpp"

#include <utility>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace haptic::server {
namespace {

grpc::StatusCode code_of(Refusal::Code code) {
  switch (code) {
    case Refusal::Code::kInvalid:
      return grpc::StatusCode::INVALID_ARGUMENT;
    case Refusal::Code::kNotFound:
      return grpc::StatusCode::NOT_FOUND;
    case Refusal::Code::kExists:
      return grpc::StatusCode::ALREADY_EXISTS;
    case Refusal::Code::kPrecondition:
      return grpc::StatusCode::FAILED_PRECONDITION;
    case Refusal::Code::kPermission:
      return grpc::StatusCode::PERMISSION_DENIED;
    case Refusal::Code::kExhausted:
      return grpc::StatusCode::RESOURCE_EXHAUSTED;
    case Refusal::Code::kAborted:
      return grpc::StatusCode::ABORTED;
    case Refusal::Code::kUnavailable:
      return grpc::StatusCode::UNAVAILABLE;
  }
  return grpc::StatusCode::INTERNAL;
}

}  // namespace

grpc::Status to_status(const Refusal& refusal) {
  const grpc::StatusCode code = code_of(refusal.code);
  google::rpc::Status status;
  status.set_code(code);
  status.set_message(refusal.message.str());
  google::rpc::ErrorInfo info;
  info.set_reason(refusal.reason.str());
  info.set_domain("hapticd");
  for (const auto& [name, value] : refusal.details)
    (*info.mutable_metadata())[name.str()] = value.str();
  status.add_details()->PackFrom(info);
  if (!refusal.field.empty()) {
    google::rpc::BadRequest bad;
    auto* violation = bad.add_field_violations();
    violation->set_field(refusal.field.str());
    violation->set_description(refusal.message.str());
    status.add_details()->PackFrom(bad);
  }
  return {code, refusal.message.str(), status.SerializeAsString()};
}

}  // namespace haptic::server
