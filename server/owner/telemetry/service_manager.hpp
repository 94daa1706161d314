#pragma once
/// Tells systemd of the daemon (sd_notify(3); Type=notify and WatchdogSec of the unit): that
/// it serves, that it stops, and, again and again, that the loop ticks. Main's thread only; the
/// loop never knows of it. Without systemd all of it does nothing.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "haptic/core/time.hpp"

namespace haptic::server {

class ServiceManager {
 public:
  using Send = std::function<void(const std::string& state)>;

  /// `watchdog`: the silence after which the manager ends the daemon; none: it does not watch.
  ServiceManager(Send send, std::optional<core::Duration> watchdog, bool present = true);
  /// The one that started this process, by $NOTIFY_SOCKET and $WATCHDOG_USEC.
  [[nodiscard]] static ServiceManager of_environment();

  /// True if one started this process.
  [[nodiscard]] bool present() const noexcept { return present_; }
  /// `status`: one line for `systemctl status`.
  void ready(const std::string& status) const;
  void stopping() const;

  /// Time between two calls of pulse(); absent: none is wanted.
  [[nodiscard]] std::optional<core::Duration> pulse_period() const;
  /// `ticks` of the loop so far. The watchdog is fed only if there are more than at the last call:
  /// a loop that stands still must not be kept alive by the threads that do not.
  void pulse(std::uint64_t ticks);

 private:
  Send send_;
  std::optional<core::Duration> watchdog_;
  bool present_;
  std::uint64_t ticks_{0};
};

}  // namespace haptic::server
