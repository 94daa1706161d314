/// haptic-relay: trouble between a client and a server, from a scenario file, until SIGINT or
/// SIGTERM.
///
///   haptic-relay --scenario tests/relay/scenarios/loss_05.textproto --tcp 29470 --udp 29471
///   hapticctl --server 127.0.0.2:29470 watch

#include <CLI/CLI.hpp>
#include <csignal>
#include <iostream>

#include "tests/relay/relay.hpp"

int main(int argc, char** argv) {
  haptic::test::RelaySetup setup;
  std::string scenario;
  CLI::App cli("haptic-relay - delays, loses, doubles and reorders what a scenario says");
  cli.add_option("--scenario", scenario, "scenario file (textproto)")->required();
  cli.add_option("--listen", setup.listen_host, "address that clients connect to (127.0.0.2)");
  cli.add_option("--server", setup.server_host, "address that the server listens at (127.0.0.1)");
  cli.add_option("--tcp", setup.tcp_port, "TCP port, the same at both addresses");
  cli.add_option("--udp", setup.udp_port, "UDP port, the same at both addresses");
  CLI11_PARSE(cli, argc, argv);
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  try {
    if (setup.tcp_port == 0 && setup.udp_port == 0) {
      throw std::runtime_error("--tcp, --udp: one of them must be given");
    }
    setup.scenario = haptic::test::read_scenario(scenario);
    const haptic::test::Relay relay(setup);
    std::cout << setup.scenario.name << ": " << setup.scenario.what << std::endl;
    int signal = 0;
    sigwait(&signals, &signal);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "haptic-relay: " << error.what() << "\n";
    return 2;
  }
}
