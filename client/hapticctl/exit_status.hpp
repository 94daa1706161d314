#pragma once
/// The exit status of hapticctl; its help and its man page have the same table.

#include "commands.hpp"

namespace haptic::ctl {

enum ExitStatus : int {
  kDone = 0,
  kFailed = 1,
  kUsage = 2,        ///< bad command line, variable or configuration file
  kUnreachable = 3,  ///< no hapticd answers
  kRefused = 4,      ///< hapticd refused what was asked
  kFaulted = 5,      ///< the device is in FAULT
};

[[nodiscard]] inline ExitStatus exit_status(const client::ClientError& error) {
  if (dynamic_cast<const DeviceInFault*>(&error) != nullptr ||
      error.server_reason() == "FAULT_PERSISTS") {
    return kFaulted;
  }
  switch (error.reason()) {
    case client::ErrorReason::kUnreachable:
    case client::ErrorReason::kTimeout:
      return kUnreachable;
    case client::ErrorReason::kInvalidArgument:
      return kUsage;
    case client::ErrorReason::kNoSuchDevice:
    case client::ErrorReason::kLeaseHeld:
    case client::ErrorReason::kNotReady:
    case client::ErrorReason::kPermissionDenied:
      return kRefused;
    case client::ErrorReason::kClosed:
    case client::ErrorReason::kProtocol:
      break;
  }
  return kFailed;
}

}  // namespace haptic::ctl
