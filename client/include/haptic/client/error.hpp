#pragma once
/// The one exception of the library, and its reasons.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

namespace haptic::client {

enum class ErrorReason : std::uint8_t {
  kUnreachable,       ///< no server answers at this address
  kTimeout,           ///< no answer in time
  kNoSuchDevice,      ///< the server has no device of this name
  kLeaseHeld,         ///< another controller has the device; the message names it
  kInvalidArgument,   ///< the message names the field, its value and what is allowed
  kNotReady,          ///< the message names what is missing yet, or used up
  kPermissionDenied,  ///< this session may not ask for that, for example an observer for force
  kClosed,            ///< the session ended
  kProtocol,          ///< an answer that this library does not understand
};

/// Thrown by calls that wait for an answer. what() is for people, reason() for programs.
class ClientError : public std::runtime_error {
 public:
  ClientError(ErrorReason reason, const std::string& message, std::string server_reason = {})
      : std::runtime_error(message), reason_(reason), server_reason_(std::move(server_reason)) {}
  [[nodiscard]] ErrorReason reason() const noexcept { return reason_; }
  /// The server's stable reason string, e.g. "STREAM_TOO_YOUNG"; empty if it gave none.
  [[nodiscard]] const std::string& server_reason() const noexcept { return server_reason_; }

 private:
  ErrorReason reason_;
  std::string server_reason_;
};

}  // namespace haptic::client
