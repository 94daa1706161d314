#include "tests/relay/udp_relay.hpp"

#include <asio/buffer.hpp>

#include <utility>

namespace haptic::test {
namespace {

/// More clients than any test has; a flood from many ports must not use up all descriptors.
constexpr std::size_t kMostFlows = 64;

/// Flows have different seeds; the first has that of the virtual link.
std::uint64_t seed_of(const Scenario& scenario, std::uint64_t flow, bool down) {
  return scenario.seed + (down ? 1000 : 0) + 10'000 * flow;
}

}  // namespace

UdpRelay::Flow::Flow(UdpRelay& owner, const Endpoint& from, std::uint64_t number)
    : relay(owner),
      client(from),
      socket(relay.context_, relay.server_.protocol()),
      up(relay.context_, relay.clock_,
         ImpairedLink(relay.scenario_.up, seed_of(relay.scenario_, number, false), Carrier::kUdp),
         [this](const Packet& packet) { to_server(packet); }),
      down(
          relay.context_, relay.clock_,
          ImpairedLink(relay.scenario_.down, seed_of(relay.scenario_, number, true), Carrier::kUdp),
          [this](const Packet& packet) {
            asio::error_code dropped;
            relay.socket_.send_to(asio::buffer(packet), client, 0, dropped);
          }) {
  // From the relay's own address, so that the server never sees the client's.
  socket.bind({relay.socket_.local_endpoint().address(), 0});
  read();
}

void UdpRelay::Flow::to_server(const Packet& packet) {
  asio::error_code dropped;
  socket.send_to(asio::buffer(packet), relay.server_, 0, dropped);
}

void UdpRelay::Flow::read() {
  socket.async_receive(asio::buffer(buffer), [this](asio::error_code error, std::size_t size) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      down.send({buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(size)});
    }
    read();  // an error is the echo of a datagram to a closed port
  });
}

UdpRelay::UdpRelay(asio::io_context& context, RelayClock& clock, const Scenario& scenario,
                   const Endpoint& listen, const Endpoint& server, Attacker attacker)
    : context_(context),
      clock_(clock),
      scenario_(scenario),
      server_(server),
      attacker_(std::move(attacker)),
      socket_(context, listen) {
  read();
}

void UdpRelay::read() {
  socket_.async_receive_from(
      asio::buffer(buffer_), from_, [this](asio::error_code error, std::size_t size) {
        if (error == asio::error::operation_aborted) return;
        auto entry = flows_.find(from_);
        if (!error && entry == flows_.end() && flows_.size() < kMostFlows) {
          entry = flows_.emplace(from_, std::make_unique<Flow>(*this, from_, flows_.size())).first;
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

}  // namespace haptic::test
