#include "server/owner/event_log.hpp"

#include <spdlog/spdlog.h>

#include <utility>
#include <vector>

namespace haptic::server {
namespace {

spdlog::level::level_enum level_of(DeviceEvent::Kind kind) {
  switch (kind) {
    case DeviceEvent::Kind::kFault:
      return spdlog::level::err;
    case DeviceEvent::Kind::kLost:
    case DeviceEvent::Kind::kLeaseExpired:
      return spdlog::level::warn;
    case DeviceEvent::Kind::kStaleness:
    case DeviceEvent::Kind::kLimiter:
      return spdlog::level::debug;
    case DeviceEvent::Kind::kState:
    case DeviceEvent::Kind::kFaultCleared:
    case DeviceEvent::Kind::kClosing:
    case DeviceEvent::Kind::kTransport:
    case DeviceEvent::Kind::kLease:
    case DeviceEvent::Kind::kClamp:
      return spdlog::level::info;
  }
  return spdlog::level::info;
}

}  // namespace

EventLog::EventLog(std::string device, std::function<std::string()> holder)
    : device_(std::move(device)), holder_(std::move(holder)) {}

void EventLog::on_record(const core::TickRecord& record) {
  std::vector<DeviceEvent> events;
  detector_.step(record, "", events);
  for (const DeviceEvent& event : events) {
    if (event.message.empty() || event.message == event.reason.view()) {
      spdlog::log(level_of(event.kind), "{}: {}", device_, event.reason.view());
    } else {
      spdlog::log(level_of(event.kind), "{}: {}: {}", device_, event.reason.view(),
                  event.message.view());
    }
  }
  lease(record.input.command);
}

void EventLog::lease(const core::CommandSnapshot& command) {
  if (command.lease_held && (!held_ || command.tenure != tenure_)) {
    spdlog::info("{}: lease {} granted to '{}'", device_, command.tenure, holder_());
  } else if (!command.lease_held && held_) {
    spdlog::info("{}: lease {} ended", device_, tenure_);
  }
  held_ = command.lease_held;
  tenure_ = command.tenure;
}

}  // namespace haptic::server
