/// A wall in joint space: the first virtual coordinate may not pass --stop. The wall is a plane, so
/// the server keeps the probe behind it at 1 kHz, and force may begin beyond it: the plane says
/// which way is out.

#include <algorithm>
#include <thread>

#include "example.hpp"

int main(int argc, char** argv) {
  using namespace haptic;
  using std::chrono::steady_clock;
  double stop = 0.314;  // 18 degrees
  CLI::App cli("haptic-example-virtual-wall - a stop on the first coordinate");
  cli.add_option("--stop", stop, "largest value of the first coordinate, m or rad");
  return examples::run(cli, argc, argv, [&](client::Connection& server) {
    const auto session = server.open({.client_name = "virtual wall",
                                      .nominal_rate_hz = 200,
                                      .re_engage = true,
                                      .on_event = examples::print_event,
                                      .on_disconnect = examples::print_end});
    session->engage_when_ready();
    if (session->device().faults != 0) std::fprintf(stderr, "in FAULT: hapticctl clear-fault\n");
    client::Plane wall{.normal = std::vector<double>(session->device().coordinates.size()),
                       .offset = stop};
    wall.normal.at(0) = 1.0;
    auto next = steady_clock::now();
    while (session->connected() && examples::stop_requested == 0) {
      next = std::max(next + std::chrono::milliseconds(5), steady_clock::now());
      std::this_thread::sleep_until(next);
      const std::vector<double> x = session->state().x_probe;
      if (!x.empty()) session->publish(client::Proxy::behind({wall}, x));
    }
    return examples::stop_requested != 0 ? 0 : 1;
  });
}
