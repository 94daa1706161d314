#include "tests/relay/presser.hpp"

#include <algorithm>
#include <cmath>

#include "tests/relay/daemon.hpp"

namespace haptic::test {

using namespace std::chrono_literals;

namespace {

bool at_rest(const client::DeviceState& state) {
  return !state.x_probe.empty() &&
         std::all_of(state.x_probe.begin(), state.x_probe.end(),
                     [](double x) { return std::abs(x - Daemon::kTarget) < 1e-4; });
}

}  // namespace

void UsedInOrder::add(const client::DeviceState& state) {
  if (state.lease_epoch != epoch_) newest_used_ = 0;
  epoch_ = state.lease_epoch;
  if (state.proxy_seq_used == 0) return;
  if (state.proxy_seq_used < newest_used_) holds_ = false;
  newest_used_ = state.proxy_seq_used;
}

Presser::Presser(const std::string& address) : connection_(address) {
  client::SessionOptions options;
  options.client_name = "presser";
  options.nominal_rate_hz = kRate;
  options.reconnect = client::Reconnect::kWithBackoff;
  options.re_engage = true;
  options.timeout = 20s;  // through a link that loses every third packet
  options.on_state = [this](const client::DeviceState& state) { order_.add(state); };
  options.on_event = [this](const client::Event& event) {
    const std::lock_guard lock(mutex_);
    events_.insert(event.reason);
  };
  session_ = connection_.open(options);
  session_->engage_when_ready();
  thread_ = std::thread([this] { run(); });
}

Presser::~Presser() {
  running_ = false;
  thread_.join();
  session_->close();
}

bool Presser::heard(const std::string& reason) const {
  const std::lock_guard lock(mutex_);
  return events_.count(reason) > 0;
}

/// The proxy is free until force is granted, then moves up to 0.15 rad into the device.
void Presser::run() {
  const auto begin = std::chrono::steady_clock::now();
  auto next = begin;
  double depth = 0.0;
  while (running_) {
    const client::DeviceState state = session_->state();
    if (!state.x_probe.empty()) {
      const double t =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      const bool engaged = state.state == client::Lifecycle::kEngaged;
      depth = engaged ? std::min(0.15, depth + 0.002) : 0.0;
      const double press = depth * (1.0 + 0.2 * std::sin(6.0 * t));
      std::vector<double> x = state.x_probe;
      if (engaged) x.assign(x.size(), Daemon::kTarget - press);
      session_->publish(state.gain == 0.0 ? client::Proxy::free() : client::Proxy::held(x));
    }
    next = std::max(next + 10ms, std::chrono::steady_clock::now());
    std::this_thread::sleep_until(next);
  }
}

bool serves(const std::string& address) {
  client::Connection connection(address);
  const auto answers = [&] {
    try {
      return !connection.devices(500ms).empty();
    } catch (const client::ClientError&) {
      return false;
    }
  };
  if (!within(60s, answers)) return false;
  std::atomic<bool> rests{false};
  const auto watch = connection.watch("finger", 100.0, [&](const client::DeviceState& state) {
    if (state.state == client::Lifecycle::kIdle && at_rest(state)) rests = true;
  });
  return within(60s, [&] { return rests.load(); });
}

}  // namespace haptic::test
