#pragma once
/// The commands of hapticctl. Each returns its exit status and throws ClientError.

#include <cstdint>
#include <string>
#include <vector>

#include "haptic/client/client.hpp"

namespace haptic::ctl {

struct Options {
  std::string server{client::kDefaultServer};
  std::string device{};
  bool tls{false};
  client::TlsOptions tls_options{};
  client::Priority priority{client::Priority::kPrimary};
  bool json{false};
  double rate_hz{10.0};
  double seconds{0.0};
  bool hold{false};
  std::string reason{};
  std::vector<std::uint32_t> faults{};
  double device_damping{1.0};  ///< doctor: b, N s/m
  double damping{0.0};         ///< doctor: B of Z_q, N s/m
  std::string output{};        ///< calibrate: the file to write
};

/// The help and the man page have the same table.
enum ExitStatus : int {
  kDone = 0,
  kFailed = 1,
  kUsage = 2,        ///< bad command line, variable or configuration file
  kUnreachable = 3,  ///< no hapticd answers
  kRefused = 4,      ///< hapticd refused what was asked
  kFaulted = 5,      ///< the device is in FAULT
};

int info(const Options& options);
int health(const Options& options);
int watch(const Options& options);
int engage(const Options& options);
int link(const Options& options);
int estop(const Options& options);
int clear_fault(const Options& options);
int restart_front(const Options& options);
int doctor(const Options& options);
int calibrate(const Options& options);
int find(const Options& options);

/// The device is in FAULT; hapticctl ends with a status of its own.
class DeviceInFault : public client::ClientError {
 public:
  explicit DeviceInFault(const std::string& message)
      : ClientError(client::ErrorReason::kNotReady, message) {}
};

/// The server, by TLS if the options ask for it.
[[nodiscard]] client::Connection connect(const Options& options);
/// The server's devices: the one with this name, or all if `name` is empty. Throws kNoSuchDevice,
/// naming the devices there are.
[[nodiscard]] std::vector<client::DeviceInfo> meant(client::Connection& server,
                                                    const std::string& name);
/// "DEVICE_SILENT, LOOP_LATE"; "none" if there are none.
[[nodiscard]] inline std::string joined(const std::vector<std::string>& names) {
  if (names.empty()) return "none";
  std::string text = names.front();
  for (std::size_t i = 1; i < names.size(); ++i) text += ", " + names[i];
  return text;
}
/// Prints the JSON if --json was given, else the text, and the end of the line.
void answer(const Options& options, const std::string& json, const std::string& text);
/// False once SIGINT or SIGTERM came, or `seconds` (0: no limit) have passed since the first call.
[[nodiscard]] bool go_on(double seconds);

}  // namespace haptic::ctl
