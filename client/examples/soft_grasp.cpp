/// A remote simulation: a soft finger closing on a soft cylinder at 60 Hz. Each step takes the
/// newest haptic probe, finds the proxy that the object allows, and streams it; hapticd turns it
/// into force.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <thread>

#include "haptic/client/client.hpp"
#include "soft_finger.hpp"
#include "until_signal.hpp"

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::microseconds kPeriod{1'000'000 / 60};

struct Options {
  std::string server{haptic::client::kDefaultServer};
  std::string device{};
  double seconds{0.0};
  bool verbose{false};
  std::string carriers{"auto"};
};

haptic::client::Carriers carriers(const std::string& word) {
  if (word == "grpc") return haptic::client::Carriers::kGrpcOnly;
  if (word == "udp") return haptic::client::Carriers::kUdpOnly;
  return haptic::client::Carriers::kAutomatic;
}

int run(const Options& options) {
  haptic::client::Connection server(options.server);
  haptic::client::SessionOptions wanted;
  wanted.device = options.device;
  wanted.client_name = "soft grasp";
  wanted.nominal_rate_hz = 60.0;
  wanted.reconnect = haptic::client::Reconnect::kWithBackoff;
  wanted.re_engage = true;
  wanted.carriers = carriers(options.carriers);
  wanted.derive_planes = true;  // the object's surface, between two steps; one block: the finger
  const auto session = server.open(wanted);
  if (session->device().coordinates.size() != 2) {
    std::fprintf(stderr, "soft grasp needs a finger: a device with two joint angles\n");
    return 1;
  }
  session->engage_when_ready();

  haptic::examples::SoftFinger finger;
  const auto start = Clock::now();
  long steps = 0, touching = 0;
  double peak = 0.0;
  auto next = start;
  while (haptic::examples::stop_requested == 0) {
    next = std::max(next + kPeriod, Clock::now());  // absolute; never a burst after a pause
    std::this_thread::sleep_until(next);
    const double t = std::chrono::duration<double>(Clock::now() - start).count();
    if (options.seconds > 0.0 && t >= options.seconds) break;

    const haptic::client::DeviceState state = session->state();
    if (state.x_probe.size() != 2) continue;
    const auto step = finger.step({state.x_probe[0], state.x_probe[1]});
    using haptic::client::Proxy;
    session->publish(step.touching ? Proxy::held({step.x[0], step.x[1]}) : Proxy::free());

    ++steps;
    touching += step.touching ? 1 : 0;
    peak = std::max(peak, std::abs(state.tau_a.empty() ? 0.0 : state.tau_a[0]));
    if (options.verbose && steps % 60 == 0) {
      std::printf("%6.1f s  %-10s  %s  tau_a %7.2f N\n", t, haptic::client::name(state.state),
                  step.touching ? "touching" : "free    ",
                  state.tau_a.empty() ? 0.0 : state.tau_a[0]);
      std::fflush(stdout);
    }
  }
  const auto sent = session->statistics();
  std::printf(
      "soft grasp: %ld steps, touching in %.0f %%, peak |tau_a| %.2f N, %llu samples sent\n", steps,
      steps > 0 ? 100.0 * static_cast<double>(touching) / static_cast<double>(steps) : 0.0, peak,
      static_cast<unsigned long long>(sent.sent));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App cli("haptic-example-soft-grasp - a soft finger grasps a soft cylinder");
  cli.add_option("--server", options.server, "host:port or unix:/path");
  cli.add_option("--device", options.device, "its name; the only one where there is one");
  cli.add_option("--seconds", options.seconds, "stop after this long; 0: until interrupted");
  cli.add_option("--carriers", options.carriers, "auto, or one alone")
      ->check(CLI::IsMember({"auto", "grpc", "udp"}));
  cli.add_flag("--verbose", options.verbose, "a line every second");
  CLI11_PARSE(cli, argc, argv);
  haptic::examples::stop_on_signal();
  try {
    return run(options);
  } catch (const haptic::client::ClientError& error) {
    std::fprintf(stderr, "soft grasp: %s\n", error.what());
    return 1;
  }
}
