/// A remote simulation: a soft finger closes on a soft cylinder, at 60 Hz. Each step takes the
/// newest haptic probe, finds the proxy that the object allows, and publishes it with the contacts
/// around it; hapticd turns them into force.

#include <algorithm>
#include <cmath>
#include <map>
#include <thread>

#include "example.hpp"
#include "soft_finger.hpp"

namespace {

using namespace haptic;
using client::Carriers;
using Clock = std::chrono::steady_clock;
constexpr std::chrono::microseconds kPeriod{1'000'000 / 60};

const std::map<std::string, Carriers> kCarriers{
    {"auto", Carriers::kAutomatic}, {"grpc", Carriers::kGrpcOnly}, {"udp", Carriers::kUdpOnly}};

struct Options {
  std::string device{};
  double seconds{0.0};
  bool verbose{false};
  std::string carriers{"auto"};
};

/// The pads near the object, as contacts: the server goes on with them between two steps, and knows
/// them before they touch. They say which way is out, wherever the simulation joins.
client::Proxy contacts(const client::Session& session, const examples::SoftFinger& finger,
                       const examples::Joints& x) {
  auto near = finger.contacts(x, client::contact_horizon(session.round_trip(), kPeriod));
  return near.empty() ? client::Proxy::free()
                      : client::Proxy::behind(std::move(near), {x.begin(), x.end()});
}

int grasp(client::Connection& server, const Options& options) {
  const auto session = server.open({
      .device = options.device,
      .client_name = "soft grasp",
      .nominal_rate_hz = 60.0,
      .carriers = kCarriers.at(options.carriers),
      .reconnect = client::Reconnect::kWithBackoff,
      .re_engage = true,
  });
  if (session->device().coordinates.size() != 2) {
    std::fprintf(stderr, "soft grasp needs a finger: a device with two joint angles\n");
    return 1;
  }
  session->engage_when_ready();

  examples::SoftFinger finger;
  const auto start = Clock::now();
  long steps = 0, touching = 0;
  double peak = 0.0;
  auto next = start;
  while (examples::stop_requested == 0) {
    next = std::max(next + kPeriod, Clock::now());  // absolute; never a burst after a pause
    std::this_thread::sleep_until(next);
    const double t = std::chrono::duration<double>(Clock::now() - start).count();
    if (options.seconds > 0.0 && t >= options.seconds) break;

    const client::DeviceState state = session->state();
    if (state.x_probe.size() != 2) continue;
    const auto step = finger.step({state.x_probe[0], state.x_probe[1]});
    session->publish(contacts(*session, finger, step.x));

    const double force = state.tau_a.empty() ? 0.0 : state.tau_a[0];
    ++steps;
    touching += step.touching ? 1 : 0;
    peak = std::max(peak, std::abs(force));
    if (options.verbose && steps % 60 == 0) {
      std::printf("%6.1f s  %-10s  %s  tau_a %7.2f N\n", t, client::name(state.state),
                  step.touching ? "touching" : "free    ", force);
      std::fflush(stdout);
    }
  }
  std::printf(
      "soft grasp: %ld steps, touching in %.0f %%, peak |tau_a| %.2f N, %llu samples sent\n", steps,
      steps > 0 ? 100.0 * static_cast<double>(touching) / static_cast<double>(steps) : 0.0, peak,
      static_cast<unsigned long long>(session->statistics().sent));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App cli("haptic-example-soft-grasp - a soft finger grasps a soft cylinder");
  cli.add_option("--device", options.device, "its name; empty: the only device");
  cli.add_option("--seconds", options.seconds, "stop after this long; 0: until interrupted");
  cli.add_option("--carriers", options.carriers, "auto, or grpc or udp alone")
      ->check(CLI::IsMember(kCarriers));
  cli.add_flag("--verbose", options.verbose, "a line every second");
  return examples::run(cli, argc, argv,
                       [&](client::Connection& server) { return grasp(server, options); });
}
