#include "server/owner/telemetry/service_manager.hpp"

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <systemd/sd-daemon.h>

#include <cstddef>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "server/base/descriptor.hpp"

namespace haptic::server {

namespace {

/// A manager that hangs may not hold up the thread that hears SIGTERM, as sd_notify() would.
constexpr timeval kManagersPatience{0, 100'000};

/// Sends as sd_notify() does, to a file or an abstract name ("@..."), and leaves out what cannot be
/// sent in time.
void send_to_manager(const std::string& state) {
  const char* const given = std::getenv("NOTIFY_SOCKET");
  const std::string_view place = given != nullptr ? given : "";
  sockaddr_un name{};
  if (place.empty() || place.size() >= sizeof name.sun_path) return;
  name.sun_family = AF_UNIX;
  place.copy(name.sun_path, place.size());
  if (place.front() == '@') name.sun_path[0] = '\0';
  const Descriptor socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  setsockopt(socket.get(), SOL_SOCKET, SO_SNDTIMEO, &kManagersPatience, sizeof kManagersPatience);
  sendto(socket.get(), state.data(), state.size(), MSG_NOSIGNAL,
         reinterpret_cast<const sockaddr*>(&name),
         static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + place.size()));
}

}  // namespace

ServiceManager::ServiceManager(Send send, std::optional<core::Duration> watchdog, bool present)
    : send_(std::move(send)), watchdog_(watchdog), present_(present) {}

ServiceManager ServiceManager::of_environment() {
  std::uint64_t microseconds = 0;
  const bool watched = sd_watchdog_enabled(0, &microseconds) > 0;
  return {send_to_manager,
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
