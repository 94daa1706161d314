#pragma once
/// The measurements of the network's path, each a few lines of CSV (haptic-bench-network).
/// `blocks`: alternations; CONTRIBUTING.md#measuring wants 20 or more.

#include <cstdint>
#include <string>

namespace haptic::bench {

/// From the making of a sample to the mailbox by UDP, AEAD and protobuf included, against a bare
/// datagram of the same size.
void udp_one_way(int blocks);

/// From publish() to the mailbox by gRPC, on TCP and on a UNIX socket, against a bare gRPC stream.
void stream_one_way(int blocks);

/// What one datagram costs the server: receive, AEAD, parse, ingress, and all in one go.
void datagram_cost(int blocks);

/// The proxy's age when a tick uses it, from publish() on, behind the relay with 10 ms each way and
/// losses of 0, 1, 5 and 10 %: by UDP and by gRPC against a WebSocket and JSON service.
struct WebSocketPeer {
  std::string
      client{};  ///< command that publishes, takes "URL SECONDS RATE_HZ", prints "P50 P99" in us
  std::uint16_t port{0};  ///< where its service listens on 127.0.0.1
};
void age_at_use(const WebSocketPeer& peer, int blocks);

}  // namespace haptic::bench
