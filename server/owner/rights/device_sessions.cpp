#include "server/owner/rights/device_sessions.hpp"

#include <utility>

#include "server/owner/rights/settings_policy.hpp"

namespace haptic::server {
namespace {

bool needs_tick(Request::Kind kind) {
  return kind == Request::Kind::kStop || kind == Request::Kind::kEngage ||
         kind == Request::Kind::kRelease || kind == Request::Kind::kClear;
}

Settings flat(const core::RenderSettings& from) {
  return {values(from.stiffness),  values(from.damping), values(from.force_limit),
          values(from.slew_limit), from.renderer,        from.direction_guard};
}

}  // namespace

DeviceSessions::DeviceSessions(DeviceUnit& unit, const SessionRules& rules)
    : unit_(unit),
      rules_(rules),
      ingress_(unit.proxies, unit.config().kinematics->space().n_x()),
      lease_{rules.lease_timeout},
      settings_(unit.config().scene) {
  if (unit.config().tracker) {
    tracker_.emplace(unit.poses, unit.config(), rules.tracker_fresh_end, rules.lease_timeout);
  }
  publish_settings(settings_);
}

void DeviceSessions::handle(const Request& request) {
  if (loop_ended_ && needs_tick(request.kind)) return answer(request.id, kClosing);
  switch (request.kind) {
    case Request::Kind::kStop:
      stopped_locally_ = stopped_locally_ || request.local;
      pending_.add(request, ++command_.stop_id);
      post();
      stop_reason_ = request.text.str();
      return;
    case Request::Kind::kEngage:
      return ask_loop(request, command_.engage_id);
    case Request::Kind::kRelease:
      return ask_loop(request, command_.release_id);
    case Request::Kind::kClear:
      return clear_faults(request);
    case Request::Kind::kSettings:
      return update_settings(request);
    case Request::Kind::kCancel:
      return cancel(request.id);
    case Request::Kind::kOpen:
      return open(request);
    case Request::Kind::kTrack:
      return open_tracker(request);
    case Request::Kind::kClose:
    case Request::Kind::kLose:
      return close(request);
    case Request::Kind::kAdmitSession:
    case Request::Kind::kAdmitObserver:
    case Request::Kind::kAdmitWatch:
      return;
  }
}

void DeviceSessions::ask_loop(const Request& request, std::uint64_t& counter) {
  if (const auto refusal = not_holder(request.session_id)) return answer(request.id, *refusal);
  pending_.add(request, ++counter);
  post();
}

void DeviceSessions::clear_faults(const Request& request) {
  const std::uint32_t wanted = request.faults.any() ? request.faults.bits() : ~std::uint32_t{0};
  const core::FaultSet active(seen_.faults.bits() & wanted);
  if (!active.any()) {
    answer(request.id);
    return;
  }
  if (active.has(core::Fault::kEmergencyStop) && stopped_locally_ && !request.local) {
    return answer(request.id, {Refusal::Code::kPermission, "STOPPED_LOCALLY",
                               "'" + unit_.name() +
                                   "' was stopped on the host that runs hapticd: it is cleared "
                                   "there"});
  }
  pending_.add_clear(request, {active, seen_.stop_id});
  post_next_clear();
}

void DeviceSessions::update_settings(const Request& request) {
  if (const auto refusal = not_holder(request.session_id)) return answer(request.id, *refusal);
  // An Engage that the loop has not answered yet may switch force on before these settings arrive.
  const bool engaging = command_.engage_id != seen_.engage_id;
  const core::LifecycleState state = engaging ? core::LifecycleState::kEngaging : seen_.state;
  const Outcome<SettingsAnswer> outcome =
      apply_settings(request.settings, settings_, unit_.config(), state);
  if (!outcome) return answer(request.id, outcome.refusal);
  publish_settings(outcome.value->applied);
  for (const std::string& sentence : outcome.value->clamped) {
    tell(DeviceEvent::Kind::kClamp, "CLAMPED", sentence);
  }
  answer(request.id).settings = flat(settings_);
}

void DeviceSessions::cancel(std::uint64_t id) {
  if (pending_.cancel(id)) take_engage_back();
}

/// A client that was told that its Engage failed must not feel it act: a tick that comes after all
/// releases.
void DeviceSessions::take_engage_back() {
  ++command_.release_id;
  post();
}

Verdict DeviceSessions::accept(const PoseSample& pose) {
  if (tracker_) return tracker_->accept(pose);
  return {IngressVerdict::kOldEpoch, "the scene has no tracker"};
}

void DeviceSessions::begin_closing() {
  if (command_.closing) return;
  command_.closing = true;
  post();
  if (newcomer_ && newcomer_->granted) end_lease();
  if (newcomer_) refuse_newcomer(kClosing);
  tell(DeviceEvent::Kind::kClosing, "CLOSING", kClosing.message.str());
  if (!lease_.has_holder) out_.events.back().lease_epoch = 0;
}

void DeviceSessions::loop_ended() {
  loop_ended_ = true;
  pending_.refuse_all(kClosing, out_.answers);
}

Outbox DeviceSessions::take() {
  return std::exchange(out_, {});
}

DeviceStatus DeviceSessions::status() const {
  DeviceStatus status;
  status.ticked = seen_.now;
  status.state = seen_.state;
  status.faults = seen_.faults;
  status.renderer = settings_.renderer;
  status.controller = lease_.client_name;
  status.holder = lease_.session_id;
  status.detached = lease_.detached;
  if (tracker_) status.tracker = tracker_->client_name();
  status.carrier = ingress_.carrier();
  status.samples = ingress_.counters();
  status.records_dropped = unit_.records.dropped();
  return status;
}

TickTold DeviceSessions::told(const core::TickRecord& record) const noexcept {
  const std::uint32_t tenure = record.input.command.tenure;
  Carrier carrier = Carrier::kNone;
  if (record.proxy.mode != core::ProxyMode::kNone) {
    carrier = ingress_.carrier_of(record.proxy.seq, record.input.now - record.proxy.age);
  }
  return {record, carrier, tenure == 0 ? 0 : tenure + lease_.resumes};
}

void DeviceSessions::step(const core::TickRecord& record) {
  const core::CommandSnapshot& command = record.input.command;
  seen_ = {record.input.now,      record.life.state, record.faults(),    record.life.stop_id,
           record.life.engage.id, record.life.gain,  command.lease_held, command.tenure};
  const std::size_t told = out_.events.size();
  detector_.step(record, stop_reason_, out_.events);
  for (std::size_t i = told; i < out_.events.size(); ++i) {
    // Under the epoch that clients know; the record has the tenure.
    if (out_.events[i].lease_epoch != 0) out_.events[i].lease_epoch += lease_.resumes;
  }
  const bool stop_is_on = seen_.faults.has(core::Fault::kEmergencyStop);
  if (!stop_is_on && seen_.stop_id == command_.stop_id) stopped_locally_ = false;
  look_after_lease(record);
  const std::size_t answered = out_.answers.size();
  if (pending_.step(record, out_.answers)) take_engage_back();
  // A stream whose every sample is refused looks like no stream to the tick; here the reason is
  // known.
  for (std::size_t i = answered; i < out_.answers.size(); ++i) {
    auto& refusal = out_.answers[i].refusal;
    if (!refusal || !(refusal->reason == "STREAM_STALE") || ingress_.last_refusal().empty())
      continue;
    refusal->message =
        refusal->message.str() + "; a sample was refused: " + std::string(ingress_.last_refusal());
  }
  post_next_clear();
}

void DeviceSessions::answer(std::uint64_t id, const Refusal& refusal) {
  answer(id).refusal = refusal;
}

Answer& DeviceSessions::answer(std::uint64_t id) {
  out_.answers.emplace_back().id = id;
  return out_.answers.back();
}

void DeviceSessions::tell(DeviceEvent::Kind kind, const char* reason, const std::string& message) {
  out_.events.push_back({kind, seen_.now, reason, message, seen_.state, lease_.epoch()});
}

void DeviceSessions::post() noexcept {
  unit_.commands.publish(command_);
}

void DeviceSessions::post_next_clear() noexcept {
  const auto asked = pending_.begin_clear(command_.clear_id + 1);
  if (!asked) return;
  ++command_.clear_id;
  command_.clear = asked->faults;
  command_.clear_stop_id = asked->stop_id;
  post();
}

void DeviceSessions::publish_settings(core::RenderSettings settings) {
  settings.id = settings_.id + 1;
  settings_ = settings;
  unit_.settings.publish(settings_);
}

bool DeviceSessions::force_is_on() const noexcept {
  const bool loop_knows =
      seen_.lease_held == command_.lease_held && seen_.tenure == command_.tenure;
  return !loop_knows || seen_.gain > 0.0;
}

std::optional<Refusal> DeviceSessions::not_holder(const SessionId& session_id) const {
  if (lease_.held_by(session_id)) return std::nullopt;
  return Refusal{Refusal::Code::kPermission, "NOT_CONTROLLER",
                 lease_.has_holder
                     ? "device '" + unit_.name() + "' is controlled by '" +
                           lease_.client_name.str() +
                           "', this session is an observer: once that has left, engage again"
                     : "this session does not hold the lease of '" + unit_.name() +
                           "' (any more): open it again, then engage again"};
}

}  // namespace haptic::server
