#include "server/session/device_sessions.hpp"

#include <utility>

#include "server/base/figures.hpp"

namespace haptic::server {
namespace {

Refusal closing() {
  return {Refusal::Code::kUnavailable, "CLOSING", "the server is shutting down", {}};
}

}  // namespace

DeviceSessions::DeviceSessions(DeviceUnit& unit, Telemetry& telemetry, std::size_t index,
                               SessionRules rules)
    : unit_(unit),
      telemetry_(telemetry),
      index_(index),
      rules_(rules),
      ingress_(unit.proxies, unit.config().kinematics->space().n_x()),
      lease_(rules.lease_timeout),
      settings_(unit.config().scene) {
  if (unit.config().tracker) {
    tracker_.emplace(unit.poses, unit.config(), rules.tracker_fresh_end, rules.lease_timeout);
  }
  publish_settings(settings_);
  telemetry_.add(index_, this);
}

DeviceSessions::~DeviceSessions() {
  telemetry_.remove(index_, this);
}

std::shared_ptr<EventQueue> DeviceSessions::subscribe(const std::string& session_id) {
  auto queue = std::make_shared<EventQueue>();
  const std::lock_guard lock(mutex_);
  queues_[session_id] = queue;
  return queue;
}

/// A stream whose every sample is refused looks like no stream to the tick; here the reason is
/// known.
Outcome<Done> DeviceSessions::explained(Outcome<Done> outcome) const {
  if (!outcome && outcome.refusal.reason == "STREAM_STALE") {
    const std::string why = ingress_.last_refusal();
    if (!why.empty()) outcome.refusal.message += "; a sample was refused: " + why;
  }
  return outcome;
}

Ticket DeviceSessions::engage(const std::string& session_id, const Answer& answer) {
  std::optional<Refusal> refusal;
  Ticket ticket = 0;
  {
    const std::lock_guard lock(mutex_);
    refusal = not_holder(session_id);
    if (!refusal) {
      ++command_.engage_id;
      post();
      ticket = pending_.add_engage(
          command_.engage_id, session_id,
          [this, answer](const Outcome<Done>& outcome) { answer(explained(outcome)); });
    }
  }
  if (refusal) answer(*refusal);
  return ticket;
}

Ticket DeviceSessions::release(const std::string& session_id, const Answer& answer) {
  std::optional<Refusal> refusal;
  Ticket ticket = 0;
  {
    const std::lock_guard lock(mutex_);
    refusal = not_holder(session_id);
    if (!refusal) {
      ++command_.release_id;
      post();
      ticket = pending_.add_release(command_.release_id, session_id, answer);
    }
  }
  if (refusal) answer(*refusal);
  return ticket;
}

Ticket DeviceSessions::emergency_stop(const std::string& reason, Answer answer) {
  const std::lock_guard lock(mutex_);
  ++command_.stop_id;
  post();
  stop_reason_ = reason;
  return pending_.add_stop(command_.stop_id, std::move(answer));
}

Ticket DeviceSessions::clear_faults(core::FaultSet faults, ClearAnswered answer) {
  {
    const std::lock_guard lock(mutex_);
    const std::uint32_t wanted = faults.any() ? faults.bits() : ~std::uint32_t{0};
    const core::FaultSet active(newest_.faults().bits() & wanted);
    if (active.any()) {
      const Ticket ticket = pending_.add_clear({active, newest_.life.stop_id}, std::move(answer));
      post_next_clear();
      return ticket;
    }
  }
  answer(core::FaultSet{});
  return 0;
}

bool DeviceSessions::cancel(Ticket ticket) {
  const std::lock_guard lock(mutex_);
  const auto cancelled = pending_.cancel(ticket);
  if (cancelled == PendingRequests::Cancelled::kEngage) {
    // Whoever was told that it failed must not feel it act: a tick that comes after all releases.
    ++command_.release_id;
    post();
  }
  return cancelled != PendingRequests::Cancelled::kNothing;
}

Outcome<SettingsAnswer> DeviceSessions::update_settings(const std::string& session_id,
                                                        const SettingsRequest& request) {
  const std::lock_guard lock(mutex_);
  if (auto refusal = not_holder(session_id)) return *refusal;
  // An Engage that the loop has not answered yet may switch force on before these settings arrive.
  const bool engaging = command_.engage_id != newest_.life.engage.id;
  const core::DeviceState state = engaging ? core::DeviceState::kEngaging : newest_.life.state;
  Outcome<SettingsAnswer> outcome = apply_settings(request, settings_, unit_.config(), state);
  if (outcome) {
    publish_settings(outcome.value->applied);
    outcome.value->applied = settings_;
    for (const SettingsClamp& clamp : outcome.value->clamped) {
      tell_everyone({DeviceEvent::Kind::kClamp, newest_.input.now, "CLAMPED",
                     clamp.field + " = " + figure(clamp.asked) + ": held at " +
                         figure(clamp.applied) + ", " + clamp.why,
                     newest_.life.state, lease_.epoch()});
    }
  }
  return outcome;
}

void DeviceSessions::begin_closing() {
  Closures closures;
  {
    const std::lock_guard lock(mutex_);
    if (command_.closing) return;
    command_.closing = true;
    post();
    if (newcomer_) {
      closures.push_back([call = std::move(newcomer_->answer)] { call(closing()); });
      newcomer_.reset();
    }
    tell_everyone({DeviceEvent::Kind::kClosing, newest_.input.now, "CLOSING",
                   "the server is shutting down", newest_.life.state,
                   lease_.held() ? lease_.epoch() : 0});
  }
  PendingRequests::run(closures);
}

bool DeviceSessions::holds_lease(const std::string& session_id) const {
  const std::lock_guard lock(mutex_);
  return lease_.held_by(session_id);
}

std::string DeviceSessions::controller() const {
  const std::lock_guard lock(mutex_);
  return lease_.client_name();
}

unsigned DeviceSessions::observers() const {
  const std::lock_guard lock(mutex_);
  const bool holder_listens = lease_.held() && queues_.count(lease_.session_id()) > 0;
  return static_cast<unsigned>(queues_.size()) - (holder_listens ? 1U : 0U);
}

bool DeviceSessions::may_be_resumed(const std::string& session_id) const {
  const std::lock_guard lock(mutex_);
  return lease_.held_by(session_id) && lease_.detached();
}

bool DeviceSessions::would_resume(const std::string& resume) const {
  const std::lock_guard lock(mutex_);
  return !command_.closing && resumes(resume);
}

core::RenderSettings DeviceSessions::settings() const {
  const std::lock_guard lock(mutex_);
  return settings_;
}

DeviceSessions::Stamp DeviceSessions::stamp(const core::TickRecord& record) const noexcept {
  const std::uint32_t grant = record.input.command.lease_epoch;
  Stamp stamp{Carrier::kNone, grant == 0 ? 0 : grant + resumes_};
  if (record.proxy.mode != core::ProxyMode::kNone) {
    stamp.carrier = ingress_.carrier_of(record.proxy.seq, record.input.now - record.proxy.age);
  }
  return stamp;
}

core::TickRecord DeviceSessions::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

void DeviceSessions::on_record(const core::TickRecord& record) {
  Closures closures;
  {
    const std::lock_guard lock(mutex_);
    newest_ = record;
    std::vector<DeviceEvent> events;
    detector_.step(record, stop_reason_, events);
    for (DeviceEvent& event : events) {
      // Under the epoch that clients know; the record has the grant.
      if (event.lease_epoch != 0) event.lease_epoch += lease_.resumes();
      tell_everyone(event);
    }

    look_after_lease(record, closures);
    pending_.step(record, closures);
    post_next_clear();
  }
  PendingRequests::run(closures);
}

void DeviceSessions::post() noexcept {
  unit_.commands.publish(command_);
}

void DeviceSessions::post_next_clear() noexcept {
  if (!pending_.clear_waits()) return;
  const AskedClear asked = pending_.begin_clear(++command_.clear_id);
  command_.clear = asked.faults;
  command_.clear_stop_id = asked.stop_id;
  post();
}

void DeviceSessions::restore_scene_settings() {
  publish_settings(unit_.config().scene);
  settings_due_ = false;
}

void DeviceSessions::publish_settings(core::RenderSettings settings) {
  settings.id = settings_.id + 1;
  settings_ = settings;
  unit_.settings.publish(settings_);
}

void DeviceSessions::tell_everyone(const DeviceEvent& event) {
  for (const auto& [session_id, queue] : queues_) queue->push(event);
}

bool DeviceSessions::force_is_on() const noexcept {
  const core::CommandSnapshot& seen = newest_.input.command;
  const bool loop_knows =
      seen.lease_held == command_.lease_held && seen.lease_epoch == command_.lease_epoch;
  return !loop_knows || newest_.life.gain > 0.0;
}

std::optional<Refusal> DeviceSessions::not_holder(const std::string& session_id) const {
  if (lease_.held_by(session_id)) return std::nullopt;
  return Refusal{Refusal::Code::kPermission,
                 "NOT_CONTROLLER",
                 lease_.held()
                     ? "device '" + name() + "' is controlled by '" + lease_.client_name() +
                           "', this session is an observer"
                     : "this session does not hold the lease of '" + name() + "' (any more)",
                 {}};
}

}  // namespace haptic::server
