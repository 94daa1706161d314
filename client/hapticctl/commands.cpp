#include "commands.hpp"

#include <chrono>
#include <csignal>
#include <cstdio>

#include "say.hpp"

namespace haptic::ctl {

client::Connection connect(const Options& options) {
  return options.tls ? client::Connection(options.server, options.tls_options)
                     : client::Connection(options.server);
}

std::vector<client::DeviceInfo> meant(client::Connection& server, const std::string& name) {
  std::vector<client::DeviceInfo> all = server.devices();
  if (name.empty()) return all;
  std::vector<std::string> names;
  for (const client::DeviceInfo& device : all) {
    if (device.name == name) return {device};
    names.push_back(device.name);
  }
  throw client::ClientError(client::ErrorReason::kNoSuchDevice,
                            "--device \"" + name + "\": must be one of " + joined(names));
}

void answer(const Options& options, const std::string& json, const std::string& text) {
  say("%s\n", options.json ? json : text);
  std::fflush(stdout);
}

namespace {
volatile std::sig_atomic_t interrupted = 0;
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

}  // namespace haptic::ctl
