/// The relay between plain sockets does what the virtual link does, which has tests of its own.

#include "tests/relay/relay.hpp"

#include <gtest/gtest.h>

#include <asio.hpp>

#include <chrono>
#include <thread>

#include "tests/support/link/impaired_link.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;
using asio::ip::tcp;
using asio::ip::udp;
using Steady = std::chrono::steady_clock;

const asio::ip::address kServer = asio::ip::make_address("127.0.0.1");
const asio::ip::address kRelay = asio::ip::make_address("127.0.0.2");

Scenario scenario(const std::string& ways) {
  return parse_scenario("what: 'a test' duration_s: 5 " + ways, "test");
}

/// Two UDP sockets with the relay between them.
struct Datagrams {
  explicit Datagrams(const Scenario& trouble)
      : server(context, udp::endpoint(kServer, 0)), client(context, udp::endpoint(kServer, 0)) {
    RelaySetup setup;
    setup.scenario = trouble;
    setup.udp_port = server.local_endpoint().port();
    relay = std::make_unique<Relay>(setup);
    client.connect({kRelay, setup.udp_port});
  }
  void send(std::uint32_t number) { client.send(asio::buffer(&number, sizeof number)); }
  /// Everything that the server gets until nothing came for 300 ms.
  std::vector<std::uint32_t> received() {
    std::vector<std::uint32_t> numbers;
    server.non_blocking(true);
    for (auto last = Steady::now(); Steady::now() - last < 300ms;) {
      std::uint32_t number = 0;
      asio::error_code error;
      server.receive_from(asio::buffer(&number, sizeof number), from, 0, error);
      if (error) {
        std::this_thread::sleep_for(1ms);
        continue;
      }
      numbers.push_back(number);
      last = Steady::now();
    }
    return numbers;
  }
  asio::io_context context{};
  udp::socket server, client;
  udp::endpoint from{};
  std::unique_ptr<Relay> relay{};
};

TEST(UdpRelay, LosesTheVirtualLinksPackets) {
  const Scenario trouble = scenario("seed: 9 up { loss: 0.4 }");
  ImpairedLink link(trouble.up, trouble.seed, Carrier::kUdp);
  std::vector<std::uint32_t> expected;
  for (std::uint32_t i = 0; i < 200; ++i) {
    link.send(Packet(4), LinkTime(i));
    while (link.receive(LinkTime(i))) expected.push_back(i);
  }
  ASSERT_GT(expected.size(), 50U);
  Datagrams ends(trouble);
  for (std::uint32_t i = 0; i < 200; ++i) ends.send(i);
  EXPECT_EQ(ends.received(), expected);
  EXPECT_EQ(ends.from.address(), kRelay);
  const std::uint32_t answer = 77;
  ends.server.send_to(asio::buffer(&answer, sizeof answer), ends.from);
  std::uint32_t heard = 0;
  ends.client.receive(asio::buffer(&heard, sizeof heard));
  EXPECT_EQ(heard, answer);
}

/// A TCP client sends `bytes` through the relay and half-closes; returns what the server read.
std::vector<std::uint8_t> through_tcp(const Scenario& trouble,
                                      const std::vector<std::uint8_t>& bytes) {
  asio::io_context context;
  tcp::acceptor acceptor(context, tcp::endpoint(kServer, 0));
  RelaySetup setup;
  setup.scenario = trouble;
  setup.tcp_port = acceptor.local_endpoint().port();
  const Relay relay(setup);
  tcp::socket client(context);
  client.connect({kRelay, setup.tcp_port});
  tcp::socket server = acceptor.accept();
  std::thread writer([&] {
    asio::write(client, asio::buffer(bytes));
    client.shutdown(tcp::socket::shutdown_send);
  });
  std::vector<std::uint8_t> received;
  asio::error_code end;
  asio::read(server, asio::dynamic_buffer(received), end);
  writer.join();
  EXPECT_EQ(end, asio::error::eof);
  // And back: the server's answer reaches the client after the client's end.
  asio::write(server, asio::buffer("ok", 2));
  server.close();
  std::string answer;
  asio::read(client, asio::dynamic_buffer(answer), end);
  EXPECT_EQ(answer, "ok");
  return received;
}

TEST(TcpRelay, LosesNothingAndKeepsOrder) {
  std::vector<std::uint8_t> bytes(700'000);  // more than a window
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 7 >> 3U);
  EXPECT_EQ(through_tcp(scenario("up { delay_ms: 2 jitter_sigma_ms: 2 }"), bytes), bytes);
}

}  // namespace
}  // namespace haptic::test
