#pragma once
/// The server: what it is, what it has, sessions and telemetry, stop and clear.

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

/// TLS to the server. PEM files; each is read when the connection is made.
struct TlsOptions {
  std::string ca_file{};  ///< who issued the server's certificate; empty: the system's list
  std::string certificate_file{};  ///< of this client, where the server asks for one; with its key
  std::string key_file{};
  /// The name that the server's certificate must have; empty: that of the address.
  std::string server_name{};
};

class Connection {
 public:
  /// "host:port" or "unix:/path", in plain text: for this host only. Does not wait for the server.
  explicit Connection(const std::string& address);
  /// The same by TLS. Throws kInvalidArgument naming a file that cannot be read.
  Connection(const std::string& address, const TlsOptions& tls);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  [[nodiscard]] ServerInfo server_info(std::chrono::milliseconds timeout = std::chrono::seconds(5));
  /// The standard health service's word on a device (empty: on the server as a whole): the device is
  /// open and the loop on time. Throws kUnreachable, kTimeout, kNoSuchDevice.
  [[nodiscard]] bool healthy(const std::string& device = {},
                             std::chrono::milliseconds timeout = std::chrono::seconds(5));
  [[nodiscard]] std::vector<DeviceInfo> devices(
      std::chrono::milliseconds timeout = std::chrono::seconds(5));

  /// Opens a session and waits for the server's word. Throws ClientError. The session may outlive
  /// the connection.
  [[nodiscard]] std::unique_ptr<Session> open(SessionOptions options);

  /// `rate_hz` 0: the server's default.
  [[nodiscard]] std::unique_ptr<Watch> watch(const std::string& device, double rate_hz,
                                             std::function<void(const DeviceState&)> on_state,
                                             std::function<void(const Event&)> on_event = {});

  /// What the links of the open sessions are doing. Device empty: of all.
  [[nodiscard]] LinkReport links(const std::string& device = {});

  /// Needs no session. Returns the devices now in FAULT. Device empty: all.
  std::vector<std::string> emergency_stop(const std::string& device = {},
                                          const std::string& reason = {});
  /// `faults` empty: all that are active. Returns what was cleared; throws kNotReady where a cause
  /// persists.
  std::vector<std::uint32_t> clear_fault(const std::string& device = {},
                                         const std::vector<std::uint32_t>& faults = {});

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::client
