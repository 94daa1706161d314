#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "commands.hpp"
#include "say.hpp"
#include "table.hpp"

namespace haptic::ctl {

namespace {

using Clock = std::chrono::steady_clock;
/// Refreshes faster than this are a flicker to people; --json keeps --rate.
constexpr double kFastestForPeople = 20.0;
/// Period of asking for what a state does not carry.
constexpr auto kFactsEvery = std::chrono::seconds(1);

/// One device: its newest state, kept by the stream's thread for the loop that prints.
class Watched {
 public:
  Watched(client::Connection& server, client::DeviceInfo device, const Options& options)
      : device_(std::move(device)),
        json_(options.json),
        stream_(server.watch(device_.name, options.rate_hz,
                             [this](const client::DeviceState& state) { take(state); })) {}

  /// Throws what ended the stream.
  void check() {
    conflated_ = stream_->conflated();
    if (stream_->running()) return;
    throw stream_->error().value_or(
        client::ClientError(client::ErrorReason::kClosed, "the stream ended"));
  }
  [[nodiscard]] Rows rows() const {
    const std::lock_guard lock(mutex_);
    if (newest_.seq == 0) return {device_.name + "  no state yet"};
    return table(device_, newest_, seconds(), conflated_, Screen::width());
  }
  void print() const {
    const std::lock_guard lock(mutex_);
    if (newest_.seq != 0) say("%s\n", line(device_, newest_, seconds()));
    std::fflush(stdout);
  }

 private:
  void take(const client::DeviceState& state) {
    const std::lock_guard lock(mutex_);
    if (newest_.seq == 0) first_ns_ = state.server_time_ns;
    newest_ = state;
    if (!json_) return;
    // A reader that is slow makes this stream slow, and the server conflates: no line is stale.
    nlohmann::json all = state_json(device_, state);
    all["conflated"] = conflated_.load();
    say("%s\n", dump(all));
    std::fflush(stdout);
  }
  [[nodiscard]] double seconds() const {
    return static_cast<double>(newest_.server_time_ns - first_ns_) * 1e-9;
  }

  client::DeviceInfo device_;
  bool json_;
  mutable std::mutex mutex_;
  client::DeviceState newest_;
  std::int64_t first_ns_{0};
  std::atomic<std::uint64_t> conflated_{0};
  std::unique_ptr<client::Watch> stream_;  // last: its callbacks use the others
};

}  // namespace

int watch(const Options& options) {
  client::Connection server = connect(options);
  std::vector<std::unique_ptr<Watched>> all;
  for (const client::DeviceInfo& device : meant(server, options.device)) {
    all.push_back(std::make_unique<Watched>(server, device, options));
  }
  Screen screen;
  const bool in_place = isatty(STDOUT_FILENO) == 1;
  client::ServerInfo facts;
  Clock::time_point next_facts{};
  const std::chrono::duration<double> pause(1.0 / std::min(options.rate_hz, kFastestForPeople));
  while (go_on(options.seconds)) {
    std::this_thread::sleep_for(pause);
    for (const auto& watched : all) watched->check();
    if (options.json) continue;
    if (!in_place) {
      for (const auto& watched : all) watched->print();
      continue;
    }
    if (Clock::now() >= next_facts) {
      facts = server.server_info();
      next_facts = Clock::now() + kFactsEvery;
    }
    Rows rows;
    for (const auto& watched : all) {
      for (std::string& row : watched->rows()) rows.push_back(std::move(row));
    }
    rows.push_back(loop_row(facts));
    screen.show(rows);
  }
  return 0;
}

}  // namespace haptic::ctl
