#include "server/owner/telemetry/event_log.hpp"

#include <spdlog/spdlog.h>

namespace haptic::server {
namespace {

spdlog::level::level_enum level_of(const DeviceEvent& event) {
  using Kind = DeviceEvent::Kind;
  const Kind kind = event.kind;
  if (kind == Kind::kFault) return spdlog::level::err;
  if (kind == Kind::kLost || kind == Kind::kLeaseExpired) return spdlog::level::warn;
  // Why there is no force, at most every half second.
  if (event.reason == "NOT_FELT" || event.message.view().starts_with(kWaits)) {
    return spdlog::level::info;
  }
  // A client may cause these as often as it likes.
  const bool frequent = kind == Kind::kStaleness || kind == Kind::kLimiter || kind == Kind::kClamp;
  return frequent ? spdlog::level::debug : spdlog::level::info;
}

}  // namespace

/// Under the owner's lock: the log only queues its lines (base/log.hpp).
void EventLog::on_event(std::size_t device, const DeviceEvent& event) {
  const bool says_more = !(event.message == event.reason.view());
  spdlog::log(level_of(event), "{}: {}{}{}", owner_.devices()[device].name, event.reason.view(),
              says_more ? ": " : "", says_more ? event.message.view() : "");
}

}  // namespace haptic::server
