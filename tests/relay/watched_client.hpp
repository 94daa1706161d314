#pragma once
/// A client that is a process of its own behind the relay, watched without the relay.

#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "haptic/client/client.hpp"
#include "tests/relay/daemon.hpp"
#include "tests/relay/presser.hpp"
#include "tests/system/process.hpp"

namespace haptic::test {

class WatchedClient {
 public:
  static constexpr double kPressed = 0.5;  ///< N

  WatchedClient(const Daemon& daemon, const std::string& program,
                std::vector<std::string> arguments)
      : process(program, std::move(arguments)),
        watching(daemon.address()),
        watch_(watching.watch("finger", Presser::kRate, [this](const client::DeviceState& state) {
          order_.add(state);
          engaged = state.state == client::Lifecycle::kEngaged;
          pressing = state.gain == 1.0 && std::abs(state.tau_elastic[0]) > kPressed;
          lease_epoch = state.lease_epoch;
        })) {}

  [[nodiscard]] bool in_order() const { return order_.holds(); }

  Process process;
  client::Connection watching;
  std::atomic<bool> engaged{false}, pressing{false};
  std::atomic<std::uint32_t> lease_epoch{0};

 private:
  UsedInOrder order_{};
  std::unique_ptr<client::Watch> watch_;
};

/// True if there is a client for the web.
inline const bool kHasWebPresser = *HAPTIC_NODE != '\0';

/// web_presser.mjs, at Presser::kRate.
inline WatchedClient web_presser(const Daemon& daemon) {
  return {daemon,
          HAPTIC_NODE,
          {HAPTIC_SOURCE_DIR "/tests/relay/web_presser.mjs", HAPTIC_BINARY_DIR "/client/js",
           "http://" + daemon.web_behind_relay(), Daemon::kToken, std::to_string(Daemon::kTarget)}};
}

}  // namespace haptic::test
