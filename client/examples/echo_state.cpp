/// The first thing to try: observe a device and print where it is.

#include <thread>

#include "example.hpp"

int main(int argc, char** argv) {
  using namespace haptic;
  CLI::App cli("haptic-example-echo-state - the states of a device");
  return examples::run(cli, argc, argv, [](client::Connection& server) {
    client::SessionOptions options;
    options.observer = true;
    options.client_name = "echo state";
    options.state_rate_hz = 5;
    options.on_state = [](const client::DeviceState& state) {
      std::printf("%8llu  %-9s  q", static_cast<unsigned long long>(state.seq),
                  client::name(state.state));
      for (const double q : state.q) std::printf(" %9.5f", q);
      std::printf("  x_probe");
      for (const double x : state.x_probe) std::printf(" %9.5f", x);
      std::printf("\n");
      std::fflush(stdout);
    };
    options.on_event = examples::print_event;
    options.on_disconnect = examples::print_end;
    const auto session = server.open(options);
    while (session->connected() && examples::stop_requested == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return examples::stop_requested != 0 ? 0 : 1;
  });
}
