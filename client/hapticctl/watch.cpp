#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "commands.hpp"
#include "haptic/client/client.hpp"

namespace haptic::ctl {

namespace {

using Clock = std::chrono::steady_clock;

std::string json_line(const std::string& device, const client::DeviceState& s,
                      std::uint64_t conflated) {
  const nlohmann::json line = {{"device", device},
                               {"seq", s.seq},
                               {"server_time_ns", s.server_time_ns},
                               {"state", client::name(s.state)},
                               {"mode", s.mode == client::Mode::kHeld ? "held" : "free"},
                               {"staleness", client::name(s.staleness)},
                               {"proxy_seq_used", s.proxy_seq_used},
                               {"proxy_age_us", s.proxy_age.count()},
                               {"gain", s.gain},
                               {"transport", client::name(s.transport)},
                               {"q", s.q},
                               {"q_dot", s.q_dot},
                               {"x_probe", s.x_probe},
                               {"x", s.x},
                               {"q_star", s.q_star},
                               {"tau_a", s.tau_a},
                               {"tau_elastic", s.tau_elastic},
                               {"faults", s.faults},
                               {"limiters", s.limiters},
                               {"projection", s.projection},
                               {"lease_epoch", s.lease_epoch},
                               {"conflated", conflated}};
  return line.dump();
}

/// A force as a bar about the middle: "[     ###|        ]".
std::string bar(double value, double limit) {
  constexpr int kHalf = 12;
  const int filled =
      limit > 0.0 && std::isfinite(value)
          ? std::clamp(static_cast<int>(std::lround(value / limit * kHalf)), -kHalf, kHalf)
          : 0;
  std::string text(2 * kHalf + 1, ' ');
  text[kHalf] = '|';
  for (int i = 1; i <= std::abs(filled); ++i) {
    text[static_cast<std::size_t>(filled < 0 ? kHalf - i : kHalf + i)] = '#';
  }
  return "[" + text + "]";
}

class Table {
 public:
  Table(client::DeviceInfo device, bool in_place)
      : device_(std::move(device)), in_place_(in_place) {}

  void show(const client::DeviceState& s, const client::ServerInfo& server,
            std::uint64_t conflated) {
    in_place_ ? block(s, server, conflated) : line(s);
    std::fflush(stdout);
  }

 private:
  void line(const client::DeviceState& s) const {
    std::printf("%9.3f s  %-9s %-5s age %6.1f ms  gain %.2f ", seconds(s), client::name(s.state),
                client::name(s.staleness), age_ms(s), s.gain);
    for (std::size_t i = 0; i < s.q.size(); ++i) std::printf(" q%zu %8.5f", i, s.q[i]);
    for (const double tau : s.tau_a) std::printf("  tau_a %7.3f", tau);
    std::printf("  faults %s\n", fault_names(s.faults).c_str());
  }

  void block(const client::DeviceState& s, const client::ServerInfo& server,
             std::uint64_t conflated) {
    if (lines_ > 0) std::printf("\x1b[%dA", lines_);
    lines_ = 0;
    row("%s  %s  %s  age %.1f ms  gain %.2f  %s  t %.1f s", device_.name.c_str(),
        client::name(s.state), client::name(s.staleness), age_ms(s), s.gain,
        client::name(s.transport), seconds(s));
    std::size_t actuated = 0;
    for (std::size_t i = 0; i < s.q.size() && i < device_.dofs.size(); ++i) {
      const auto& dof = device_.dofs[i];
      const double star = i < s.q_star.size() ? s.q_star[i] : s.q[i];
      if (dof.actuated && actuated < s.tau_a.size()) {
        const double limit =
            actuated < device_.force_limit.size() ? device_.force_limit[actuated] : dof.max_effort;
        row("  %-10s q %9.5f  q* %9.5f %-3s  tau_a %7.2f / %g %s", dof.name.c_str(), s.q[i], star,
            dof.unit.c_str(), s.tau_a[actuated], limit, bar(s.tau_a[actuated], limit).c_str());
        ++actuated;
      } else {
        row("  %-10s q %9.5f  q* %9.5f %-3s  sensed only", dof.name.c_str(), s.q[i], star,
            dof.unit.c_str());
      }
    }
    for (std::size_t i = 0; i < s.x_probe.size() && i < device_.coordinates.size(); ++i) {
      row("  %-10s x_probe %9.5f  proxy %9.5f %s", device_.coordinates[i].name.c_str(),
          s.x_probe[i], i < s.x.size() ? s.x[i] : std::nan(""),
          device_.coordinates[i].unit.c_str());
    }
    row("  faults %s  conflated %llu", fault_names(s.faults).c_str(),
        static_cast<unsigned long long>(conflated));
    row("  loop: %llu ticks, %llu skipped, late %.1f us p50, %.1f us p99; tick %.2f us p50",
        static_cast<unsigned long long>(server.ticks),
        static_cast<unsigned long long>(server.skipped_ticks), server.lateness_p50_us,
        server.lateness_p99_us, server.tick_p50_us);
  }

  /// One line, cut to what a terminal shows, the rest of the old one erased.
  template <typename... Arguments>
  void row(const char* format, Arguments... arguments) {
    char text[160];
    std::snprintf(text, sizeof text, format, arguments...);
    std::printf("%s\x1b[K\n", text);
    ++lines_;
  }

  [[nodiscard]] static double age_ms(const client::DeviceState& s) {
    return s.proxy_seq_used == 0 ? 0.0 : static_cast<double>(s.proxy_age.count()) * 1e-3;
  }
  double seconds(const client::DeviceState& s) const {
    if (first_ns_ == 0) first_ns_ = s.server_time_ns;
    return static_cast<double>(s.server_time_ns - first_ns_) * 1e-9;
  }

  client::DeviceInfo device_;
  bool in_place_;
  int lines_{0};
  mutable std::int64_t first_ns_{0};
};

}  // namespace

int watch(const Options& options) {
  client::Connection server(options.server);
  const auto devices = server.devices();
  const auto found = std::find_if(devices.begin(), devices.end(), [&](const auto& device) {
    return options.device.empty() ? devices.size() == 1 : device.name == options.device;
  });
  if (found == devices.end()) {
    std::string names;
    for (const auto& device : devices) names += (names.empty() ? "" : ", ") + device.name;
    throw client::ClientError(client::ErrorReason::kNoSuchDevice,
                              "--device \"" + options.device + "\": must be one of " + names);
  }
  std::mutex mutex;
  client::DeviceState newest;
  std::atomic<std::uint64_t> conflated{0};
  const std::string name = found->name;
  const auto stream = server.watch(name, options.rate_hz, [&](const client::DeviceState& state) {
    const std::lock_guard lock(mutex);
    newest = state;
    if (options.json) {
      std::printf("%s\n", json_line(name, state, conflated).c_str());
      std::fflush(stdout);
    }
  });

  Table table(*found, isatty(STDOUT_FILENO) == 1);
  client::ServerInfo facts = server.server_info();
  const auto pause = std::chrono::duration<double>(1.0 / std::min(options.rate_hz, 20.0));
  auto next_facts = Clock::now();
  while (stream->running() && go_on(options.seconds)) {
    conflated = stream->conflated();
    if (!options.json) {
      if (Clock::now() >= next_facts) {
        facts = server.server_info();
        next_facts = Clock::now() + std::chrono::seconds(1);
      }
      client::DeviceState state;
      {
        const std::lock_guard lock(mutex);
        state = newest;
      }
      if (state.seq > 0) table.show(state, facts, conflated);
    }
    std::this_thread::sleep_for(pause);
  }
  if (!stream->running()) {
    throw stream->error().value_or(
        client::ClientError(client::ErrorReason::kClosed, "the stream ended"));
  }
  return 0;
}

}  // namespace haptic::ctl
