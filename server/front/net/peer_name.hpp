#pragma once
/// Names of the far end of a connection (private to server/front/net).

#include <string>

namespace haptic::server {

struct PeerName {
  std::string grpc{};   ///< as gRPC calls the connection, "ipv4:127.0.0.1:5000"; empty: UNIX socket
  std::string owner{};  ///< whose it is: an IPv4 address, the /64 of an IPv6 address, a local user
};

/// Name of the peer of a socket that was accepted; owner empty: it is gone already.
[[nodiscard]] PeerName peer_name(int socket);

}  // namespace haptic::server
