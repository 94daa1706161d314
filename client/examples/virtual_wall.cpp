/// A wall in joint space: the first virtual coordinate may not pass --stop. The proxy is the probe,
/// clipped at the wall; free on this side of it. The classical god-object in one dimension.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <thread>

#include "haptic/client/client.hpp"
#include "say.hpp"
#include "until_signal.hpp"

int main(int argc, char** argv) {
  std::string address = haptic::client::kDefaultServer;
  double stop = 0.314;  // 18 degrees
  CLI::App cli("haptic-example-virtual-wall - a stop on the first coordinate");
  cli.add_option("--server", address, "host:port or unix:/path");
  cli.add_option("--stop", stop, "largest value of the first coordinate, m or rad");
  CLI11_PARSE(cli, argc, argv);
  haptic::examples::stop_on_signal();
  try {
    haptic::client::Connection server(address);
    haptic::client::SessionOptions options;
    options.client_name = "virtual wall";
    options.nominal_rate_hz = 200;
    options.re_engage = true;
    options.on_event = haptic::examples::print_event;
    options.on_disconnect = haptic::examples::print_end;
    const auto session = server.open(options);
    session->engage_when_ready();
    if (session->device().faults != 0) std::fprintf(stderr, "in FAULT: hapticctl clear-fault\n");
    auto next = std::chrono::steady_clock::now();
    while (session->connected() && haptic::examples::stop_requested == 0) {
      next = std::max(next + std::chrono::milliseconds(5), std::chrono::steady_clock::now());
      std::this_thread::sleep_until(next);
      std::vector<double> x = session->state().x_probe;
      if (x.empty()) continue;
      const bool touching = x[0] > stop;
      x[0] = std::min(x[0], stop);
      session->publish(touching ? haptic::client::Proxy::held(std::move(x))
                                : haptic::client::Proxy::free());
    }
    return haptic::examples::stop_requested != 0 ? 0 : 1;
  } catch (const haptic::client::ClientError& error) {
    std::fprintf(stderr, "virtual wall: %s\n", error.what());
    return 1;
  }
}
