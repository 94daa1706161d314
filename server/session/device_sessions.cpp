#include "server/session/device_sessions.hpp"

#include <utility>

namespace haptic::server {
namespace {

/// How long a newcomer waits for its predecessor's fade, which takes fade_end - hold_end: 1 s at most
/// (render_scene.cpp), and 80 ms by default.
constexpr core::Duration kNewcomerPatience = std::chrono::milliseconds(1500);

void run(const PendingRequests::Closures& closures) {
  for (const auto& closure : closures) closure();
}

Refusal held_by(const std::string& device, const std::string& holder) {
  return {Refusal::Code::kExists,
          "LEASE_HELD",
          "device '" + device + "' is controlled by '" + holder + "'",
          {}};
}

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

void DeviceSessions::close(const std::string& session_id) {
  Closures closures;
  {
    const std::lock_guard lock(mutex_);
    queues_.erase(session_id);
    if (newcomer_ && newcomer_->request.session_id == session_id) newcomer_.reset();
    if (lease_.held_by(session_id)) end_lease(closures);
  }
  run(closures);
}

void DeviceSessions::open_controller(const LeaseRequest& request, core::TimePoint now,
                                     const LeaseAnswer& answer) {
  Closures closures;
  std::optional<Refusal> refusal;
  {
    const std::lock_guard lock(mutex_);
    const Outcome<core::StalenessLimits> limits =
        lease_staleness(request, unit_.config().scene.staleness, rules_.fresh_end);
    if (command_.closing) {
      refusal = closing();
    } else if (lease_.held()) {
      refusal = held_by(name(), lease_.client_name());
    } else if (newcomer_) {
      refusal = held_by(name(), newcomer_->request.client_name);
    } else if (!limits) {
      refusal = limits.refusal;
    } else {
      newcomer_ = Newcomer{request, *limits.value, answer, now + kNewcomerPatience};
      if (!force_is_on()) grant_newcomer(now, closures);
    }
  }
  if (refusal) answer(*refusal);
  run(closures);
}

/// A stream whose every sample is refused looks like no stream to the tick; here the reason is known.
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
    const core::FaultSet active(newest_.faults.bits() & wanted);
    if (active.any()) {
      const Ticket ticket = pending_.add_clear({active, newest_.stop_id}, std::move(answer));
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
  const bool engaging = command_.engage_id != newest_.engage.id;
  const core::DeviceState state = engaging ? core::DeviceState::kEngaging : newest_.state;
  Outcome<SettingsAnswer> outcome = apply_settings(request, settings_, unit_.config().scene, state);
  if (outcome) {
    publish_settings(outcome.value->applied);
    outcome.value->applied = settings_;
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
                   "the server is shutting down", newest_.state,
                   command_.lease_held ? command_.lease_epoch : 0});
  }
  run(closures);
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

core::RenderSettings DeviceSessions::settings() const {
  const std::lock_guard lock(mutex_);
  return settings_;
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
    for (const DeviceEvent& event : events) tell_everyone(event);

    if (lease_.expired(record.input.now, ingress_.last_accepted())) {
      tell_everyone({DeviceEvent::Kind::kLeaseExpired, record.input.now, "LEASE_EXPIRED",
                     "'" + lease_.client_name() +
                         "' sent no valid sample for the lease time and is an observer now",
                     record.state, command_.lease_epoch});
      end_lease(closures);
    }
    if (!force_is_on()) {
      if (newcomer_) {
        grant_newcomer(record.input.now, closures);
      } else if (settings_due_) {
        restore_scene_settings();
      }
    } else if (newcomer_ && record.input.now >= newcomer_->gives_up) {
      closures.push_back([call = std::move(newcomer_->answer)] {
        call(Refusal{Refusal::Code::kUnavailable,
                     "NO_ANSWER",
                     "the force of the previous controller did not fade out in time",
                     {}});
      });
      newcomer_.reset();
    }
    pending_.step(record, closures);
    post_next_clear();
  }
  run(closures);
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

void DeviceSessions::end_lease(Closures& closures) {
  const std::string session_id = lease_.session_id();
  lease_.end();
  ingress_.end_lease();
  command_.lease_held = false;
  post();
  settings_due_ = true;
  pending_.lease_ended(session_id, closures);
}

void DeviceSessions::grant_newcomer(core::TimePoint now, Closures& closures) {
  Newcomer newcomer = std::move(*newcomer_);
  newcomer_.reset();
  const LeaseRequest& request = newcomer.request;
  const std::uint32_t epoch = lease_.grant(request.session_id, request.client_name, now);
  core::RenderSettings settings = unit_.config().scene;
  settings.staleness = newcomer.staleness;
  publish_settings(settings);
  settings_due_ = false;
  ingress_.begin_lease(epoch, request.nominal_rate_hz, newcomer.staleness.hold_end);
  command_.lease_epoch = epoch;
  command_.lease_held = true;
  post();
  closures.push_back([call = std::move(newcomer.answer), lease = Lease{epoch, newcomer.staleness}] {
    call(lease);
  });
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
  return !loop_knows || newest_.gain > 0.0;
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
