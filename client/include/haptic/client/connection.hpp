#pragma once
/// A connection to hapticd: facts about the server and its devices, sessions, states without a
/// session, emergency stop.
///
/// A device argument is a name of devices(). Every call that waits for an answer throws
/// ClientError, after 5 s at the latest if no timeout is given.

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptic/client/link.hpp"
#include "haptic/client/session.hpp"
#include "haptic/client/watch.hpp"

namespace haptic::client {

/// Address of a hapticd on this host that listens where it does by default, "127.0.0.1:PORT".
extern const char* const kDefaultServer;

/// TLS to the server. Files are in PEM form; each is read when the connection is made.
struct TlsOptions {
  std::string ca_file{};  ///< of the issuer of the server's certificate; empty: the system's list
  std::string certificate_file{};  ///< of this client, if the server asks for one
  std::string key_file{};          ///< belongs to certificate_file
  /// The name that the server's certificate must have; empty: that of the address.
  std::string server_name{};
};

class Connection {
 public:
  /// `address`: "host:port" or "unix:/path". In plain text, which hapticd accepts from its own host
  /// only. Does not wait for the server.
  explicit Connection(const std::string& address);
  /// The same by TLS. Throws kInvalidArgument and names the file that cannot be read.
  Connection(const std::string& address, const TlsOptions& tls);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  [[nodiscard]] ServerInfo server_info(std::chrono::milliseconds timeout = std::chrono::seconds(5));
  /// Whether the device is open and the loop is on time, as gRPC's health service says it. `device`
  /// empty: the server as a whole.
  [[nodiscard]] bool healthy(const std::string& device = {},
                             std::chrono::milliseconds timeout = std::chrono::seconds(5));
  [[nodiscard]] std::vector<DeviceInfo> devices(
      std::chrono::milliseconds timeout = std::chrono::seconds(5));

  /// Opens a session and waits until the server agrees. Throws kLeaseHeld if another controller has
  /// the device. The session may outlive the connection.
  [[nodiscard]] std::unique_ptr<Session> open(SessionOptions options);

  /// States and events of a device without a session, until the Watch is destroyed. `rate_hz` is
  /// that of the states; 0: the server's default.
  [[nodiscard]] std::unique_ptr<Watch> watch(const std::string& device, double rate_hz,
                                             std::function<void(const DeviceState&)> on_state,
                                             std::function<void(const Event&)> on_event = {});

  /// How the links of the open sessions are. `device` empty: of all sessions.
  [[nodiscard]] LinkReport links(const std::string& device = {});

  /// Stops `device`, or all devices if it is empty: zero force at once, and the fault
  /// EMERGENCY_STOP until clear_fault(). Needs no session. Returns the devices that are in FAULT
  /// now.
  std::vector<std::string> emergency_stop(const std::string& device = {},
                                          const std::string& reason = {});
  /// Clears faults by number (fault_names() in state.hpp); `faults` empty: all that are active.
  /// Returns what was cleared. Throws kNotReady if a cause persists.
  std::vector<std::uint32_t> clear_fault(const std::string& device = {},
                                         const std::vector<std::uint32_t>& faults = {});

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::client
