#include "server/owner/rights/device_event.hpp"

#include <cmath>
#include <cstdio>

#include "server/base/figures.hpp"
#include "server/owner/rights/pending_requests.hpp"
#include "server/owner/telemetry/event_log.hpp"

namespace haptic::server {
namespace {

struct FaultSentence {
  core::Fault fault;
  const char* sentence;
};
constexpr FaultSentence kFaults[] = {
    {core::Fault::kDeviceSilent, "the device gave no sample for longer than it may"},
    {core::Fault::kDeviceLost, "the device, or the link to it, is gone"},
    {core::Fault::kSampleNotFinite, "the device reported a value that is no number"},
    {core::Fault::kSampleOutOfRange, "the device reported a value outside its range"},
    {core::Fault::kLoopLate, ""},  // with its lateness, in step()
    {core::Fault::kLateBucketFull, "the loop was late too often"},
    {core::Fault::kEmergencyStop, "an emergency stop was asked for"},
    {core::Fault::kForceOverLimit, "the device measured more force than it may give"},
    {core::Fault::kOutputNotFinite, "the computed command was no number"},
    {core::Fault::kForceOutOfRange, "the load cell reads more than it can"},
    {core::Fault::kForceTooFast, "the load cell's reading grew faster than a force can"},
    {core::Fault::kForceStuck, "the load cell's reading stood still while the drive moved on"},
    {core::Fault::kForceDisagrees, "the load cell does not read what the drive gives"},
};

/// Limits of single actuators, and a force that is missing. The others concern the proxy and are a
/// field of every state.
constexpr core::Limiter kTold[] = {
    core::Limiter::kSaturation, core::Limiter::kSlew,        core::Limiter::kPower,
    core::Limiter::kRate,       core::Limiter::kTemperature, core::Limiter::kDriveLimit,
    core::Limiter::kNotFelt,
};
constexpr const char* kNotFelt =
    "this contact's direction is felt with 0 % of its depth: no motor moves the tool that way, or "
    "the scene's prior leaves it to joints without a motor";

DeviceEvent event_of(const core::TickRecord& record, DeviceEvent::Kind kind,
                     std::string_view reason, std::string_view message) {
  const core::CommandSnapshot& command = record.input.command;
  return {kind,    record.input.now,  reason,
          message, record.life.state, command.lease_held ? command.tenure : 0};
}

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

const char* words(core::DeratingReason reason) {
  switch (reason) {
    case core::DeratingReason::kHeld:
      return "proxy held, ";
    case core::DeratingReason::kPlanes:
      return "planes that change, ";
    case core::DeratingReason::kDevice:
    case core::DeratingReason::kNone:
      break;
  }
  return "device's samples ";
}

/// Why the proxy in use is as old as it is.
std::string age_of_proxy(const core::TickRecord& record) {
  const core::ProxyInUse& proxy = record.proxy;
  return "the newest proxy is " + measured_ms(proxy.age) + " old" +
         (proxy.too_fast.comes_hz > 0.0 ? " (" + too_fast(proxy.too_fast) + ")" : "");
}

}  // namespace

/// A client that waits for force asks every 50 ms.
void EventDetector::waits(const core::TickRecord& record, std::vector<DeviceEvent>& events) {
  constexpr core::Duration kPatience{std::chrono::milliseconds(500)};
  const core::EngageAnswer& answer = record.life.engage;
  if (answer.id == answered_) return;
  answered_ = answer.id;
  const core::TimePoint now = record.input.now;
  const auto refusal = engage_refusal(answer, record.life.state);
  if (!refusal || now - refused_ > kQuiet) {
    waits_since_ = now;
    told_of_ = {};
  }
  if (!refusal) return;
  refused_ = now;
  bool& told = told_of_[static_cast<std::size_t>(answer.verdict)];
  if (told || now - waits_since_ < kPatience) return;
  told = true;
  events.push_back(event_of(record, DeviceEvent::Kind::kLimiter, refusal->reason.view(),
                            kWaits + refusal->message.str()));
}

void EventDetector::derating(const core::TickRecord& record, std::vector<DeviceEvent>& events) {
  constexpr double kMuch = 0.2;
  const core::VecA& whole = record.input.settings.stiffness;
  double allowed = 1.0;
  Eigen::Index least = 0;
  for (Eigen::Index i = 0; i < record.derating.allowed.size(); ++i) {
    if (!(record.derating.allowed[i] < allowed * whole[i])) continue;
    allowed = record.derating.allowed[i] / whole[i];
    least = i;
  }
  const bool turns = (allowed < 1.0) != (allowed_ < 1.0);
  if (!turns && std::abs(allowed - allowed_) <= kMuch * allowed_) return;
  if (told_ && record.input.now - *told_ <= kQuiet) return;
  allowed_ = allowed;
  told_ = record.input.now;
  char text[128] = "the stiffness is that of the settings again";
  if (allowed < 1.0) {
    std::snprintf(text, sizeof text, "stiffness of actuator %d: %.4g -> %.4g: %s%s old",
                  static_cast<int>(least), whole[least], record.derating.allowed[least],
                  words(record.derating.reason), measured_ms(record.derating.delay).c_str());
  }
  events.push_back(
      event_of(record, DeviceEvent::Kind::kLimiter, core::reason(core::Limiter::kDerated), text));
}

void EventDetector::limiters(const core::TickRecord& record, std::vector<DeviceEvent>& events) {
  for (const core::Limiter limiter : kTold) {
    if (!record.limiters().has(limiter)) continue;
    auto& acted = acted_[static_cast<std::size_t>(limiter)];
    const bool begins = !acted || record.input.now - *acted > kQuiet;
    acted = record.input.now;
    if (!begins) continue;
    events.push_back(event_of(
        record, DeviceEvent::Kind::kLimiter, core::reason(limiter),
        limiter == core::Limiter::kNotFelt ? kNotFelt : limiter_sentence(limiter, record)));
  }
}

void EventDetector::step(const core::TickRecord& record, const std::string& stop_reason,
                         std::vector<DeviceEvent>& events) {
  const auto add = [&](DeviceEvent::Kind kind, std::string_view reason,
                       const std::string& message) {
    events.push_back(event_of(record, kind, reason, message));
  };
  for (const auto& [fault, sentence] : kFaults) {
    const bool now = record.faults().has(fault);
    const bool before = faults_.has(fault);
    if (now && !before) {
      std::string message = sentence;
      if (fault == core::Fault::kLoopLate) {
        message = "the loop woke up " + measured_ms(record.input.loop.lateness) + " late";
      } else if (fault == core::Fault::kEmergencyStop && !stop_reason.empty()) {
        message = "emergency stop: " + stop_reason;
      }
      add(DeviceEvent::Kind::kFault, core::reason(fault), message);
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
        "force was given up: " + age_of_proxy(record) + ", the limit is " +
            milliseconds(record.input.settings.staleness.fade_end) + "; a new Engage is needed");
  }
  if (record.life.state != state_) {
    const std::string change =
        std::string(core::name(state_)) + " -> " + std::string(core::name(record.life.state));
    add(DeviceEvent::Kind::kState, change, change);
  }
  if (record.proxy.level != staleness_) {
    add(DeviceEvent::Kind::kStaleness,
        std::string(core::name(staleness_)) + " -> " + std::string(core::name(record.proxy.level)),
        record.proxy.seq == 0 ? "there is no proxy" : age_of_proxy(record));
  }
  waits(record, events);
  derating(record, events);
  limiters(record, events);
  state_ = record.life.state;
  faults_ = record.faults();
  staleness_ = record.proxy.level;
}

}  // namespace haptic::server
