#include "server/session/device_event.hpp"

#include <cstdio>

#include "server/base/figures.hpp"

namespace haptic::server {
namespace {

constexpr core::Fault kFaults[] = {
    core::Fault::kDeviceSilent,     core::Fault::kDeviceLost,     core::Fault::kSampleNotFinite,
    core::Fault::kSampleOutOfRange, core::Fault::kLoopLate,       core::Fault::kLateBucketFull,
    core::Fault::kEmergencyStop,    core::Fault::kForceOverLimit, core::Fault::kOutputNotFinite,
};

std::string fault_sentence(core::Fault fault, const core::TickRecord& record,
                           const std::string& stop_reason) {
  switch (fault) {
    case core::Fault::kDeviceSilent:
      return "the device gave no sample for longer than it may";
    case core::Fault::kDeviceLost:
      return "the device, or the link to it, is gone";
    case core::Fault::kSampleNotFinite:
      return "the device reported a value that is no number";
    case core::Fault::kSampleOutOfRange:
      return "the device reported a value outside its range";
    case core::Fault::kLoopLate:
      return "the loop woke up " + measured_ms(record.input.loop.lateness) + " late";
    case core::Fault::kLateBucketFull:
      return "the loop was late too often";
    case core::Fault::kEmergencyStop:
      return stop_reason.empty() ? "an emergency stop was asked for"
                                 : "emergency stop: " + stop_reason;
    case core::Fault::kForceOverLimit:
      return "the device measured more force than it may give";
    case core::Fault::kOutputNotFinite:
      return "the computed command was no number";
  }
  return "unknown fault";
}

/// Limits of single actuators. The others concern the proxy and are a field of every state.
constexpr core::Limiter kActuatorLimiters[] = {
    core::Limiter::kSaturation, core::Limiter::kSlew,        core::Limiter::kPower,
    core::Limiter::kRate,       core::Limiter::kTemperature, core::Limiter::kDriveLimit,
};

std::string limiter_sentence(core::Limiter limiter, const core::TickRecord& record) {
  std::string actuators;
  for (std::size_t i = 0; i < static_cast<std::size_t>(record.effort.tau_a.size()); ++i) {
    if (!record.effort.actuator_limiters[i].has(limiter)) continue;
    const auto a = static_cast<Eigen::Index>(i);
    char text[96];
    std::snprintf(text, sizeof text, "%sactuator %zu at %.3g", actuators.empty() ? "" : ", ", i,
                  record.effort.tau_a[a]);
    actuators += text;
    if (limiter != core::Limiter::kTemperature || a >= record.effort.temperature_c.size()) continue;
    std::snprintf(text, sizeof text, " and %.0f C", record.effort.temperature_c[a]);
    actuators += text;
  }
  return "a limit holds " + (actuators.empty() ? std::string("the force") : actuators);
}

}  // namespace

void EventDetector::limiters(const core::TickRecord& record, std::vector<DeviceEvent>& events) {
  for (const core::Limiter limiter : kActuatorLimiters) {
    if (!record.limiters().has(limiter)) continue;
    auto& acted = acted_[static_cast<std::size_t>(limiter)];
    const bool begins = !acted || record.input.now - *acted > kQuiet;
    acted = record.input.now;
    if (!begins) continue;
    const core::CommandSnapshot& command = record.input.command;
    events.push_back({DeviceEvent::Kind::kLimiter, record.input.now, core::reason(limiter),
                      limiter_sentence(limiter, record), record.life.state,
                      command.lease_held ? command.tenure : 0});
  }
}

void EventDetector::step(const core::TickRecord& record, const std::string& stop_reason,
                         std::vector<DeviceEvent>& events) {
  const auto add = [&](DeviceEvent::Kind kind, std::string_view reason,
                       const std::string& message) {
    const core::CommandSnapshot& command = record.input.command;
    events.push_back({kind, record.input.now, reason, message, record.life.state,
                      command.lease_held ? command.tenure : 0});
  };
  for (const core::Fault fault : kFaults) {
    const bool now = record.faults().has(fault);
    const bool before = faults_.has(fault);
    if (now && !before) {
      add(DeviceEvent::Kind::kFault, core::reason(fault),
          fault_sentence(fault, record, stop_reason));
    } else if (before && !now) {
      add(DeviceEvent::Kind::kFaultCleared, core::reason(fault), "fault cleared");
    }
  }
  if (record.life.lost && record.proxy.level != core::Staleness::kLost) {
    add(DeviceEvent::Kind::kLost, "TRACKER_LOST",
        "force was given up: the tracker's newest pose is " +
            measured_ms(record.sensed.tracker.age) +
            " old, beyond its limit; a new Engage is needed");
  } else if (record.life.lost) {
    add(DeviceEvent::Kind::kLost, "LOST",
        "force was given up: the newest proxy is " + measured_ms(record.proxy.age) +
            " old, the limit is " + milliseconds(record.input.settings.staleness.fade_end) +
            "; a new Engage is needed");
  }
  if (record.life.state != state_) {
    const std::string change =
        std::string(core::name(state_)) + " -> " + std::string(core::name(record.life.state));
    add(DeviceEvent::Kind::kState, change, change);
  }
  if (record.proxy.level != staleness_) {
    add(DeviceEvent::Kind::kStaleness,
        std::string(core::name(staleness_)) + " -> " + std::string(core::name(record.proxy.level)),
        record.proxy.seq == 0 ? "there is no proxy"
                              : "the newest proxy is " + measured_ms(record.proxy.age) + " old");
  }
  limiters(record, events);
  state_ = record.life.state;
  faults_ = record.faults();
  staleness_ = record.proxy.level;
}

}  // namespace haptic::server
