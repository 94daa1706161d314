#pragma once
/// Addresses a server may listen on while it has no TLS (private to server/rpc).

#include <string>

namespace haptic::server {

/// Throws TransportError naming the address: not "host:port" or "unix:/path"; a host other than
/// loopback (plaintext stays on this machine); a UNIX socket that another process answers on (gRPC
/// itself would take its path away silently), or a path that is too long or no socket.
void check_listen_address(const std::string& address);

/// `address` with the port that was bound in the place of its own.
[[nodiscard]] std::string with_port(const std::string& address, int port);

}  // namespace haptic::server
