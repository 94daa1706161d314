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
  status.set_message(refusal.message);
  google::rpc::ErrorInfo info;
  info.set_reason(refusal.reason);
  info.set_domain("hapticd");
  for (const auto& [name, value] : refusal.details) (*info.mutable_metadata())[name] = value;
  status.add_details()->PackFrom(info);
  if (!refusal.field.empty()) {
    google::rpc::BadRequest bad;
    auto* violation = bad.add_field_violations();
    violation->set_field(refusal.field);
    violation->set_description(refusal.message);
    status.add_details()->PackFrom(bad);
  }
  return {code, refusal.message, status.SerializeAsString()};
}

Refusal invalid_field(std::string field, const std::string& rest) {
  std::string message = field + " " + rest;
  return {Refusal::Code::kInvalid, "INVALID_ARGUMENT", std::move(message), std::move(field)};
}

std::optional<Refusal> too_large(std::size_t bytes) {
  if (bytes <= kLargestMessage) return std::nullopt;
  const std::string limit = std::to_string(kLargestMessage);
  return Refusal{Refusal::Code::kExhausted,
                 "MESSAGE_TOO_LARGE",
                 "message of " + std::to_string(bytes) + " bytes: at most " + limit + " are taken",
                 {},
                 {{"limit", limit}}};
}

std::string sanitised(const std::string& text, std::size_t longest) {
  std::size_t size = text.size();
  if (size > longest) {
    size = longest;
    while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xC0U) == 0x80U) --size;
  }
  std::string clean = text.substr(0, size);
  for (char& c : clean) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7F) c = '?';
  }
  return clean;
}

}  // namespace haptic::server
