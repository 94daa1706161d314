/// The smallest controller: the world is empty. The proxy is free, so that the device is engaged
/// and yet neither pulls nor drags.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <thread>

#include "haptic/client/client.hpp"
#include "until_signal.hpp"

int main(int argc, char** argv) {
  std::string address = haptic::client::kDefaultServer;
  CLI::App cli("haptic-example-free-space - engaged, and nothing to feel");
  cli.add_option("--server", address, "host:port or unix:/path");
  CLI11_PARSE(cli, argc, argv);
  haptic::examples::stop_on_signal();
  try {
    haptic::client::Connection server(address);
    haptic::client::SessionOptions options;
    options.client_name = "free space";
    options.nominal_rate_hz = 100;
    const auto session = server.open(options);
    session->engage_when_ready();
    for (int step = 0; session->connected() && haptic::examples::stop_requested == 0; ++step) {
      session->publish(haptic::client::Proxy::free());
      if (step % 100 == 0) {
        const haptic::client::DeviceState state = session->state();
        std::printf("%-9s gain %.2f  force %g N\n", haptic::client::name(state.state), state.gain,
                    state.tau_a.empty() ? 0.0 : state.tau_a[0]);
        std::fflush(stdout);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return 0;
  } catch (const haptic::client::ClientError& error) {
    std::fprintf(stderr, "free space: %s\n", error.what());
    return 1;
  }
}
