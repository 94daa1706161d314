#include <chrono>
#include <csignal>
#include <cstdio>
#include <thread>

#include "commands.hpp"
#include "haptic/client/client.hpp"

namespace haptic::ctl {

namespace {

volatile std::sig_atomic_t interrupted = 0;

constexpr const char* kFaultNames[] = {
    "",          "DEVICE_SILENT",    "DEVICE_LOST",    "SAMPLE_NOT_FINITE", "SAMPLE_OUT_OF_RANGE",
    "LOOP_LATE", "LATE_BUCKET_FULL", "EMERGENCY_STOP", "FORCE_OVER_LIMIT",  "OUTPUT_NOT_FINITE"};

}  // namespace

std::string fault_names(std::uint32_t faults) {
  std::string names;
  for (unsigned bit = 0; bit < 32; ++bit) {
    if ((faults >> bit & 1U) == 0) continue;
    names += names.empty() ? "" : ", ";
    names +=
        bit < std::size(kFaultNames) && bit > 0 ? kFaultNames[bit] : "fault " + std::to_string(bit);
  }
  return names.empty() ? "none" : names;
}

bool go_on(double seconds) {
  using Clock = std::chrono::steady_clock;
  static const Clock::time_point start = [] {
    std::signal(SIGINT, [](int) { interrupted = 1; });
    std::signal(SIGTERM, [](int) { interrupted = 1; });
    return Clock::now();
  }();
  return interrupted == 0 &&
         (seconds <= 0.0 || std::chrono::duration<double>(Clock::now() - start).count() < seconds);
}

int engage(const Options& options) {
  client::Connection server(options.server);
  client::SessionOptions wanted;
  wanted.device = options.device;
  wanted.client_name = "hapticctl engage";
  wanted.nominal_rate_hz = 100.0;
  const auto session = server.open(wanted);
  std::vector<double> anchor;
  session->engage_when_ready();
  for (int step = 0; session->connected() && go_on(options.seconds); ++step) {
    const client::DeviceState state = session->state();
    if (options.hold && anchor.empty()) anchor = state.x_probe;
    session->publish(options.hold && !anchor.empty() ? client::Proxy::held(anchor)
                                                     : client::Proxy::free());
    if (step % 50 == 0) {
      std::printf("%-9s gain %.2f  tau_a", client::name(state.state), state.gain);
      for (const double tau : state.tau_a) std::printf(" %8.3f", tau);
      std::printf("  faults %s\n", fault_names(state.faults).c_str());
      std::fflush(stdout);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  if (!session->connected())
    throw client::ClientError(client::ErrorReason::kClosed, "session ended");
  session->release();
  return 0;
}

int estop(const Options& options) {
  client::Connection server(options.server);
  for (const std::string& device : server.emergency_stop(options.device, options.reason)) {
    std::printf("stopped: %s\n", device.c_str());
  }
  return 0;
}

int clear_fault(const Options& options) {
  client::Connection server(options.server);
  const auto cleared = server.clear_fault(options.device, options.faults);
  std::uint32_t bits = 0;
  for (const std::uint32_t fault : cleared) bits |= 1U << fault;
  std::printf("cleared: %s\n", fault_names(bits).c_str());
  return 0;
}

}  // namespace haptic::ctl
