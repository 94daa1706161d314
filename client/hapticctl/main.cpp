/// hapticctl: looks at a server and its devices, asks for force, stops, clears faults.

#include "command_line.hpp"
#include "say.hpp"

namespace haptic::ctl {
namespace {

ExitStatus exit_status(const client::ClientError& error) {
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

}  // namespace
}  // namespace haptic::ctl

int main(int argc, char** argv) {
  using haptic::client::ClientError;
  haptic::ctl::Options options;
  const auto parsed = haptic::ctl::parse(argc, argv, options);
  if (const int* const status = std::get_if<int>(&parsed)) return *status;
  try {
    return std::get<haptic::ctl::Command>(parsed)(options);
  } catch (const ClientError& error) {
    const haptic::ctl::ExitStatus status = haptic::ctl::exit_status(error);
    if (status == haptic::ctl::kUnreachable) {
      haptic::ctl::complain("no hapticd answers at %s", options.server);
    }
    haptic::ctl::complain("%s%s%s", std::string(error.what()),
                          error.server_reason().empty() ? "" : " - ", error.server_reason());
    return status;
  }
}
