#pragma once
/// Trouble between real sockets, without privileges: a relay for UDP and TCP that does to packets
/// what a scenario file says, with the same links and the same seed as on virtual time.
///
/// It listens where the client connects to (127.0.0.2, say) on the very ports that the server has
/// on another address of the loopback: a server names its UDP port on the stream, and that name
/// must do at the relay as well.
///
/// UDP: datagrams are delayed, lost, doubled and reordered one by one. TCP ends at the relay:
/// pieces of at most one segment meet the model of a reliable transport (ReliableLink), in order
/// and complete, late where a packet would have been lost.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/link/impaired_link.hpp"

namespace haptic::test {

struct RelaySetup {
  Scenario scenario{};
  std::string listen_host{"127.0.0.2"};
  std::string server_host{"127.0.0.1"};
  std::uint16_t tcp_port{0};  ///< 0: no TCP
  std::uint16_t udp_port{0};  ///< 0: no UDP
  /// An attacker on the way: sees every datagram of the clients as it comes, on the relay's thread;
  /// what it returns goes to the server at once, from the client's address as the server knows it.
  std::function<std::vector<Packet>(const Packet&)> attacker{};
};

class Relay {
 public:
  /// Binds, and relays on a thread of its own. Throws std::runtime_error naming the address.
  explicit Relay(const RelaySetup& setup);
  /// Ends the thread and closes every socket.
  ~Relay();
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::test
