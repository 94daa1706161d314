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

#include "haptic/client/session.hpp"
#include "haptic/client/watch.hpp"

namespace haptic::client {

/// "127.0.0.1:PORT": a hapticd that runs on this host with its default port.
extern const char* const kDefaultServer;

/// How to connect with TLS. The files are in PEM format; Connection's constructor reads them.
struct TlsOptions {
  /// Certificate of the authority that issued the server's; empty: those that the system trusts.
  std::string ca_file{};
  std::string certificate_file{};  ///< of this client, if the server asks for one
  std::string key_file{};          ///< private key of certificate_file
  /// The name that the server's certificate must have; empty: the host in the address.
  std::string server_name{};
};

class Connection {
 public:
  /// Connects without TLS, which hapticd accepts only from programs on its own host. `address` is
  /// "host:port" or "unix:/path". Returns at once, whether or not a server runs there.
  explicit Connection(const std::string& address);
  /// The same with TLS. Throws kInvalidArgument if a file cannot be read, and names it.
  Connection(const std::string& address, const TlsOptions& tls);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  [[nodiscard]] ServerInfo server_info(std::chrono::milliseconds timeout = std::chrono::seconds(5));
  /// Asks gRPC's health service. True if the device is open and the 1 kHz loop is on time; with an
  /// empty `device`, if that holds for every device of the server.
  [[nodiscard]] bool healthy(const std::string& device = {},
                             std::chrono::milliseconds timeout = std::chrono::seconds(5));
  [[nodiscard]] std::vector<DeviceInfo> devices(
      std::chrono::milliseconds timeout = std::chrono::seconds(5));

  /// Opens a session and waits until the server agrees. Throws kLeaseHeld if another controller has
  /// the device. The session may outlive the connection.
  [[nodiscard]] std::unique_ptr<Session> open(SessionOptions options);

  /// Calls on_state and on_event until the returned Watch is destroyed. `rate_hz`: how many states
  /// per second; 0: the server's default.
  [[nodiscard]] std::unique_ptr<Watch> watch(const std::string& device, double rate_hz,
                                             std::function<void(const DeviceState&)> on_state,
                                             std::function<void(const Event&)> on_event = {});

  /// Network figures of the open sessions of `device`, or of all sessions if it is empty.
  [[nodiscard]] LinkReport links(const std::string& device = {});

  /// Stops `device`, or all devices if it is empty: zero force at once, and the fault
  /// EMERGENCY_STOP until clear_fault(). Needs no session. Returns the devices that are in FAULT
  /// now.
  std::vector<std::string> emergency_stop(const std::string& device = {},
                                          const std::string& reason = {});
  /// Clears latched faults. `faults` are bit numbers of DeviceState::faults; empty: all that are
  /// active. Returns those that were cleared. Throws kNotReady if the cause of one persists.
  std::vector<std::uint32_t> clear_fault(const std::string& device = {},
                                         const std::vector<std::uint32_t>& faults = {});

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::client
