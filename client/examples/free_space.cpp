/// The smallest controller: the world is empty. The proxy is free, so that the device is engaged
/// and neither pulls nor drags.

#include <thread>

#include "example.hpp"

int main(int argc, char** argv) {
  using namespace haptic;
  CLI::App cli("haptic-example-free-space - engaged, and nothing to feel");
  return examples::run(cli, argc, argv, [](client::Connection& server) {
    const auto session = server.open({.client_name = "free space", .nominal_rate_hz = 100});
    session->engage_when_ready();
    for (int step = 0; session->connected() && examples::stop_requested == 0; ++step) {
      session->publish(client::Proxy::free());
      if (step % 100 == 0) {
        const client::DeviceState state = session->state();
        std::printf("%-9s gain %.2f  force %g N\n", client::name(state.state), state.gain,
                    state.tau_a.empty() ? 0.0 : state.tau_a[0]);
        std::fflush(stdout);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return 0;
  });
}
