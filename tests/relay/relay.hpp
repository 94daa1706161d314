#pragma once
/// A relay for UDP and TCP that does to packets what a scenario file says, with the same links and
/// the same seed as on virtual time. It needs no privileges.
///
/// It listens on another address of the loopback (127.0.0.2) than the server, on the same ports:
/// the server names its UDP port on the stream, and the client must find the relay on that port.
///
/// UDP: datagrams are delayed, lost, doubled and reordered one by one. TCP ends at the relay:
/// pieces of at most one segment meet the model of a reliable transport (ReliableLink), in order
/// and complete; a piece that would have been lost comes later.

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
  /// what it returns goes to the server at once, from the client's address as the server sees it.
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
