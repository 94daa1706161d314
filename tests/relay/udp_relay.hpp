#pragma once
/// The relay's datagrams (private to tests/relay).

#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>

#include <array>
#include <map>
#include <memory>

#include "tests/relay/timed_link.hpp"

namespace haptic::test {

class UdpRelay {
 public:
  using Endpoint = asio::ip::udp::endpoint;
  using Attacker = std::function<std::vector<Packet>(const Packet&)>;
  UdpRelay(asio::io_context& context, RelayClock& clock, const Scenario& scenario,
           const Endpoint& listen, const Endpoint& server, Attacker attacker);

 private:
  /// One client: an address of its own towards the server, so that answers find their way back.
  struct Flow {
    Flow(UdpRelay& owner, const Endpoint& from, std::uint64_t number);
    void read();
    void to_server(const Packet& packet);

    UdpRelay& relay;
    const Endpoint client;
    asio::ip::udp::socket socket;
    TimedLink<ImpairedLink> up, down;
    std::array<std::uint8_t, 65536> buffer{};
  };
  void read();

  asio::io_context& context_;
  RelayClock& clock_;
  const Scenario scenario_;
  const Endpoint server_;
  const Attacker attacker_;
  asio::ip::udp::socket socket_;
  Endpoint from_{};
  std::array<std::uint8_t, 65536> buffer_{};
  std::map<Endpoint, std::unique_ptr<Flow>> flows_{};
};

}  // namespace haptic::test
