#pragma once
/// Messages as protobuf's JSON, and failures as the Connect protocol says them. No transport.

#include <google/protobuf/util/type_resolver.h>

#include <memory>
#include <string>
#include <string_view>

#include "google/protobuf/message.h"
#include "server/crossing/outcome.hpp"

namespace haptic::server {

/// One thread.
class Json {
 public:
  Json();
  /// A serialised message of haptic.v1 as text.
  [[nodiscard]] std::string from_bytes(const google::protobuf::Descriptor& type,
                                       const std::string& bytes) const;
  [[nodiscard]] static std::string from_message(const google::protobuf::Message& message);
  /// Overwrites `message`; empty: it was read, but for fields that are unknown here. Else why not,
  /// fit for logs.
  [[nodiscard]] static std::string read(std::string_view text, google::protobuf::Message& message);
  /// The same of a body that is JSON, or protobuf's bytes.
  [[nodiscard]] static std::string read(const std::string& body, bool json,
                                        google::protobuf::Message& message);

 private:
  std::unique_ptr<google::protobuf::util::TypeResolver> types_;
};

/// {"code": "not_found", "message": ..., "details": [...]}, as of a unary call of Connect.
[[nodiscard]] std::string connect_error(const Refusal& refusal);
/// The status of HTTP that goes with it.
[[nodiscard]] unsigned http_status(Refusal::Code code) noexcept;

}  // namespace haptic::server
