#pragma once
/// Every error of the library, by reason.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

namespace haptic::client {

enum class ErrorReason : std::uint8_t {
  kUnreachable,  ///< no server there, or it went away
  kTimeout,      ///< no answer in time
  kNoSuchDevice,
  kLeaseHeld,         ///< another controller has the device; the message names it
  kInvalidArgument,   ///< the message names field, value and what is allowed
  kNotReady,          ///< the message names what is not good enough yet, or used up
  kPermissionDenied,  ///< not this session's to ask
  kClosed,            ///< the session ended
  kProtocol,          ///< the server answered what this library does not understand
};

/// Every error of the library, thrown by calls that wait for an answer.
class ClientError : public std::runtime_error {
 public:
  ClientError(ErrorReason reason, const std::string& message, std::string server_reason = {})
      : std::runtime_error(message), reason_(reason), server_reason_(std::move(server_reason)) {}
  [[nodiscard]] ErrorReason reason() const noexcept { return reason_; }
  /// The server's stable reason string, e.g. "STREAM_TOO_YOUNG"; empty where there was none.
  [[nodiscard]] const std::string& server_reason() const noexcept { return server_reason_; }

 private:
  ErrorReason reason_;
  std::string server_reason_;
};

}  // namespace haptic::client
