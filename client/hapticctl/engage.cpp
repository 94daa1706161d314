#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "commands.hpp"
#include "say.hpp"
#include "table.hpp"

namespace haptic::ctl {

namespace {

using std::chrono::milliseconds;
constexpr milliseconds kPeriod{10};
constexpr int kStepsPerLine = 50;

/// The state and, while force is not given, what it waits for.
void print(const client::Session& session, const client::DeviceState& state, double seconds,
           const Options& options) {
  const auto refusal = session.engage_refusal();
  nlohmann::json all = state_json(session.device(), state);
  all["waits"] = refusal ? nlohmann::json(refusal->what()) : nlohmann::json();
  answer(options, dump(all),
         line(session.device(), state, seconds) +
             (refusal ? std::string("  waits: ") + refusal->what() : ""));
}

}  // namespace

/// A controller without a simulation. Its proxy is free, or held where the device was when the
/// force began. Until then it is free: force does not start with a held one.
int engage(const Options& options) {
  client::Connection server = connect(options);
  client::SessionOptions wanted;
  wanted.device = options.device;
  wanted.client_name = "hapticctl engage";
  wanted.priority = options.priority;
  wanted.nominal_rate_hz = 1000.0 / static_cast<double>(kPeriod.count());
  const auto session = server.open(wanted);
  static_cast<void>(session->wait_for_state());
  std::vector<double> anchor;
  session->engage_when_ready();
  auto next = std::chrono::steady_clock::now();
  for (int step = 0; go_on(options.seconds); ++step) {
    if (!session->connected()) {
      throw client::ClientError(client::ErrorReason::kClosed, "the session ended");
    }
    const client::DeviceState state = session->state();
    if (state.faults != 0) {
      throw DeviceInFault("the device is in FAULT: " + joined(client::fault_names(state.faults)));
    }
    const bool has_force =
        state.state == client::Lifecycle::kEngaging || state.state == client::Lifecycle::kEngaged;
    if (!has_force) {
      anchor.clear();
    } else if (options.hold && anchor.empty()) {
      anchor = state.x_probe;
    }
    session->publish(anchor.empty() ? client::Proxy::free() : client::Proxy::held(anchor));
    if (step % kStepsPerLine == 0)
      print(*session, state, step * std::chrono::duration<double>(kPeriod).count(), options);
    next = std::max(next + kPeriod, std::chrono::steady_clock::now());
    std::this_thread::sleep_until(next);
  }
  session->release();
  return 0;
}

}  // namespace haptic::ctl
