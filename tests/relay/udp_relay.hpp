#pragma once
/// The relay's datagrams (private to tests/relay).

#include <asio/buffer.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>

#include <array>
#include <map>
#include <memory>
#include <utility>

#include "tests/relay/timed_link.hpp"

namespace haptic::test {

class UdpRelay {
 public:
  using Endpoint = asio::ip::udp::endpoint;
  using Attacker = std::function<std::vector<Packet>(const Packet&)>;
  UdpRelay(asio::io_context& context, RelayClock& clock, const Scenario& scenario,
           const Endpoint& listen, const Endpoint& server, Attacker attacker)
      : context_(context),
        clock_(clock),
        scenario_(scenario),
        server_(server),
        attacker_(std::move(attacker)),
        socket_(context, listen) {
    read();
  }

 private:
  /// More clients than any test has; a flood from many ports must not use up all descriptors.
  static constexpr std::size_t kMostFlows = 64;
  using Buffer = std::array<std::uint8_t, 65536>;

  /// One client: an address of its own towards the server, so that answers find their way back.
  struct Flow {
    /// Flows have different seeds; the first has that of the virtual link.
    Flow(UdpRelay& owner, const Endpoint& from, std::uint64_t number)
        : relay(owner),
          client(from),
          socket(relay.context_, relay.server_.protocol()),
          up(relay.context_, relay.clock_,
             ImpairedLink(relay.scenario_.up, relay.scenario_.seed + 10'000 * number,
                          Carrier::kUdp),
             [this](const Packet& packet) { to_server(packet); }),
          down(relay.context_, relay.clock_,
               ImpairedLink(relay.scenario_.down, relay.scenario_.seed + 1000 + 10'000 * number,
                            Carrier::kUdp),
               [this](const Packet& packet) {
                 asio::error_code dropped;
                 relay.socket_.send_to(asio::buffer(packet), client, 0, dropped);
               }) {
      // From the relay's own address, so that the server never sees the client's.
      socket.bind({relay.socket_.local_endpoint().address(), 0});
      read();
    }
    void read() {
      socket.async_receive(asio::buffer(buffer), [this](asio::error_code error, std::size_t size) {
        if (error == asio::error::operation_aborted) return;
        if (!error) down.send({buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(size)});
        read();  // an error is the echo of a datagram to a closed port
      });
    }
    void to_server(const Packet& packet) {
      asio::error_code dropped;
      socket.send_to(asio::buffer(packet), relay.server_, 0, dropped);
    }

    UdpRelay& relay;
    const Endpoint client;
    asio::ip::udp::socket socket;
    TimedLink<ImpairedLink> up, down;
    Buffer buffer{};
  };

  void read() {
    socket_.async_receive_from(
        asio::buffer(buffer_), from_, [this](asio::error_code error, std::size_t size) {
          if (error == asio::error::operation_aborted) return;
          auto entry = flows_.find(from_);
          if (!error && entry == flows_.end() && flows_.size() < kMostFlows) {
            auto flow = std::make_unique<Flow>(*this, from_, flows_.size());
            entry = flows_.emplace(from_, std::move(flow)).first;
          }
          if (!error && entry != flows_.end()) {
            Packet packet(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(size));
            if (attacker_) {
              for (const Packet& forged : attacker_(packet)) entry->second->to_server(forged);
            }
            entry->second->up.send(std::move(packet));
          }
          read();
        });
  }

  asio::io_context& context_;
  RelayClock& clock_;
  const Scenario scenario_;
  const Endpoint server_;
  const Attacker attacker_;
  asio::ip::udp::socket socket_;
  Endpoint from_{};
  Buffer buffer_{};
  std::map<Endpoint, std::unique_ptr<Flow>> flows_{};
};

}  // namespace haptic::test
