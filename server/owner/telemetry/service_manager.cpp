#include "server/owner/telemetry/service_manager.hpp"

#include <systemd/sd-daemon.h>

#include <cstdlib>
#include <utility>

namespace haptic::server {

ServiceManager::ServiceManager(Send send, std::optional<core::Duration> watchdog, bool present)
    : send_(std::move(send)), watchdog_(watchdog), present_(present) {}

ServiceManager ServiceManager::of_environment() {
  std::uint64_t microseconds = 0;
  const bool watched = sd_watchdog_enabled(0, &microseconds) > 0;
  return {[](const std::string& state) { static_cast<void>(sd_notify(0, state.c_str())); },
          watched ? std::optional<core::Duration>(
                        std::chrono::microseconds(static_cast<std::int64_t>(microseconds)))
                  : std::nullopt,
          std::getenv("NOTIFY_SOCKET") != nullptr};
}

void ServiceManager::ready(const std::string& status) const {
  send_("READY=1\nSTATUS=" + status);
}

void ServiceManager::stopping() const {
  send_("STOPPING=1\nSTATUS=force fades out, devices are disarmed");
}

std::optional<core::Duration> ServiceManager::pulse_period() const {
  if (!watchdog_) return std::nullopt;
  return *watchdog_ / 4;  // sd_watchdog_enabled(3) asks for half at most; one may come late
}

void ServiceManager::pulse(std::uint64_t ticks) {
  if (watchdog_ && ticks > ticks_) send_("WATCHDOG=1");
  ticks_ = ticks;
}

}  // namespace haptic::server
