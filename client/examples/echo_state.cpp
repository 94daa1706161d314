/// The first thing to try: watch a device as an observer and print where it is.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <thread>

#include "haptic/client/client.hpp"
#include "say.hpp"
#include "until_signal.hpp"

int main(int argc, char** argv) {
  std::string address = haptic::client::kDefaultServer;
  CLI::App cli("haptic-example-echo-state - the states of a device");
  cli.add_option("--server", address, "host:port or unix:/path");
  CLI11_PARSE(cli, argc, argv);
  haptic::examples::stop_on_signal();
  try {
    haptic::client::Connection server(address);
    haptic::client::SessionOptions options;
    options.observer = true;
    options.client_name = "echo state";
    options.state_rate_hz = 5;
    options.on_state = [](const haptic::client::DeviceState& state) {
      std::printf("%8llu  %-9s  q", static_cast<unsigned long long>(state.seq),
                  haptic::client::name(state.state));
      for (const double q : state.q) std::printf(" %9.5f", q);
      std::printf("  x_probe");
      for (const double x : state.x_probe) std::printf(" %9.5f", x);
      std::printf("\n");
      std::fflush(stdout);
    };
    options.on_event = haptic::examples::print_event;
    options.on_disconnect = haptic::examples::print_end;
    const auto session = server.open(options);
    while (session->connected() && haptic::examples::stop_requested == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return haptic::examples::stop_requested != 0 ? 0 : 1;
  } catch (const haptic::client::ClientError& error) {
    std::fprintf(stderr, "echo state: %s\n", error.what());
    return 1;
  }
}
