#pragma once
/// web_presser.mjs: a client on a WebSocket, a process of its own behind the relay, watched without
/// the relay.

#include <atomic>
#include <cmath>
#include <memory>
#include <string>

#include "haptic/client/client.hpp"
#include "tests/relay/daemon.hpp"
#include "tests/relay/presser.hpp"
#include "tests/system/process.hpp"

namespace haptic::test {

/// True if there is a client for the web.
inline const bool kHasWebPresser = *HAPTIC_NODE != '\0';

class WebPresser {
 public:
  static constexpr double kPressed = 0.5;  ///< N

  explicit WebPresser(const Daemon& daemon)
      : process(HAPTIC_NODE, {HAPTIC_SOURCE_DIR "/tests/relay/web_presser.mjs",
                              HAPTIC_BINARY_DIR "/client/js", "http://" + daemon.web_behind_relay(),
                              Daemon::kToken, std::to_string(Daemon::kTarget)}),
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

}  // namespace haptic::test
