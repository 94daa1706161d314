/// haptic-bench-network: the measurements of the network's path, by the rule of
/// CONTRIBUTING.md#measuring. tests/bench/network.sh starts the peer that it needs, and this.
///
///   haptic-bench-network [datagram|udp|stream|age]... [--blocks N]
///                        [--peer-client COMMAND --peer-port PORT]
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "tests/bench/network.hpp"
#include "tests/bench/paired.hpp"

int main(int argc, char** argv) {
  namespace bench = haptic::bench;
  std::vector<std::string> parts;
  bench::WebSocketPeer peer;
  int blocks = 20;
  CLI::App cli("haptic-bench-network - what the network's path costs");
  cli.add_option("parts", parts, "datagram, udp, stream, age; none: all")
      ->check(CLI::IsMember({"datagram", "udp", "stream", "age"}));
  cli.add_option("--peer-client", peer.client, "command that publishes by WebSocket (age)");
  cli.add_option("--peer-port", peer.port, "port of its service on 127.0.0.1 (age)");
  cli.add_option("--blocks", blocks, "alternations; of fewer than 20 nothing may be quoted")
      ->check(CLI::Range(2, 1000));
  CLI11_PARSE(cli, argc, argv);
  const auto wanted = [&](const char* part) {
    return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  if (wanted("age") && (peer.client.empty() || peer.port == 0)) {
    std::cerr << "--peer-client, --peer-port: age needs both (tests/bench/network.sh gives them)\n";
    return 2;
  }
  spdlog::set_level(spdlog::level::warn);  // sessions that come and go
  bench::print_header();
  try {
    if (wanted("datagram")) bench::datagram_cost(blocks);
    if (wanted("udp")) bench::udp_one_way(blocks);
    if (wanted("stream")) bench::stream_one_way(blocks);
    if (wanted("age")) bench::age_at_use(peer, blocks);
  } catch (const std::exception& error) {
    std::cerr << "haptic-bench-network: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
