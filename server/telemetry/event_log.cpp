#include "server/telemetry/event_log.hpp"

#include <spdlog/spdlog.h>

namespace haptic::server {

void EventLog::on_record(const core::TickRecord& record) {
  const core::CommandSnapshot& command = record.input.command;
  if (command.lease_held != held_ || command.lease_epoch != epoch_) {
    held_ = command.lease_held;
    epoch_ = command.lease_epoch;
    spdlog::info("{}: lease {} {}", device_, epoch_, held_ ? "granted" : "ended");
  }
  events_.clear();
  detector_.step(record, {}, events_);
  for (const DeviceEvent& event : events_) {
    switch (event.kind) {
      case DeviceEvent::Kind::kFault:
        spdlog::error("{}: fault {}: {}", device_, event.reason, event.message);
        break;
      case DeviceEvent::Kind::kLost:
        spdlog::warn("{}: force given up: {}", device_, event.message);
        break;
      case DeviceEvent::Kind::kStaleness:
        spdlog::debug("{}: proxy {}", device_, event.reason);
        break;
      default:
        spdlog::info("{}: {}", device_, event.reason);
    }
  }
}

}  // namespace haptic::server
