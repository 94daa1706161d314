#include "server/rpc/convert.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace haptic::server {
namespace {

using Doubles = google::protobuf::RepeatedField<double>;

template <typename Vector>
void copy(const Vector& from, Doubles* to) {
  to->Clear();
  to->Add(from.data(), from.data() + from.size());
}

std::vector<double> values(const Doubles& from) {
  return {from.begin(), from.end()};
}

void to_passivity(const core::PassivityRecord& record, v1::PassivityState& state) {
  state.set_tank(record.tank);
  state.set_storage(record.storage);
  state.set_scale(record.scale);
  state.set_observed(record.observed);
  state.set_alpha(record.alpha);
}

/// What only some devices have; a state of the others carries none of it.
void to_actuators(const core::TickRecord& record, v1::DeviceState& state) {
  copy(record.input.device.sample.tau_measured, state.mutable_tau_measured());
  core::VecQ reading = record.input.device.sample.q;
  if (record.tracker.on && reading.size() == record.q.size()) {
    // What the device says of a tracked palm is not looked at.
    constexpr auto kDofs = static_cast<Eigen::Index>(core::kPalmDofs);
    reading.segment<kDofs>(record.tracker.first_dof) =
        record.q.segment<kDofs>(record.tracker.first_dof);
  }
  const bool refused = reading.size() == record.q.size() && reading != record.q;
  copy(refused ? reading : core::VecQ{}, state.mutable_reading());
  copy(record.temperature_c, state.mutable_temperature_c());
  copy(record.drive.size() > 0 ? record.drive : record.position, state.mutable_drive());
  state.clear_actuator_limiters();
  const auto n_a = static_cast<std::size_t>(record.tau_a.size());
  const auto begin = record.actuator_limiters.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(n_a);
  if (std::none_of(begin, end, [](core::LimiterSet set) { return set.any(); })) return;
  std::for_each(begin, end, [&](core::LimiterSet set) { state.add_actuator_limiters(set.bits()); });
}

std::uint64_t whole_microseconds(core::Duration age) {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(age).count();
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, us));
}

void to_tracker(const core::TrackerRecord& record, v1::TrackerState& state) {
  state.set_seq_used(record.seq);
  state.set_age_us(whole_microseconds(record.age));
  state.set_staleness(static_cast<v1::StalenessLevel>(record.level));
}

core::Duration duration(const google::protobuf::Duration& message) {
  // Far beyond any limit of ours, far below what 64 bits of nanoseconds hold.
  const std::int64_t seconds = std::clamp<std::int64_t>(message.seconds(), -86400, 86400);
  return std::chrono::seconds(seconds) + std::chrono::nanoseconds(message.nanos());
}

const char* unit_name(core::Unit unit) {
  return unit == core::Unit::kMetre ? "m" : "rad";
}

const char* kind_name(core::CoordinateKind kind) {
  switch (kind) {
    case core::CoordinateKind::kAngle:
      return "angle";
    case core::CoordinateKind::kQuaternion:
      return "quaternion";
    case core::CoordinateKind::kLinear:
      break;
  }
  return "linear";
}

}  // namespace

void set(google::protobuf::Duration& message, core::Duration d) {
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(d);
  message.set_seconds(whole.count());
  message.set_nanos(static_cast<std::int32_t>((d - whole).count()));
}

void to_proto(const core::TickRecord& record, DeviceSessions::Stamp stamp, v1::DeviceState& state) {
  state.set_seq(record.tick);
  state.set_server_time_ns(record.input.now.time_since_epoch().count());
  copy(record.q, state.mutable_q());
  copy(record.q_a_dot, state.mutable_q_dot());
  copy(record.x_probe, state.mutable_x_probe());
  copy(record.x, state.mutable_x());
  state.set_active_planes(record.active_planes);
  if (record.passivity.on) {
    to_passivity(record.passivity, *state.mutable_passivity());
  } else {
    state.clear_passivity();
  }
  copy(record.q_star, state.mutable_q_star());
  copy(record.tau_a, state.mutable_tau_a());
  copy(record.tau_elastic, state.mutable_tau_elastic());
  state.set_proxy_seq_used(record.proxy_seq);
  state.set_proxy_age_us(whole_microseconds(record.proxy_age));
  if (record.tracker.on) {
    to_tracker(record.tracker, *state.mutable_tracker());
  } else {
    state.clear_tracker();
  }
  state.set_staleness(static_cast<v1::StalenessLevel>(record.staleness));
  state.set_gain(record.gain);
  state.set_transport(static_cast<v1::Transport>(stamp.carrier));
  state.set_state(static_cast<v1::DeviceStateName>(record.state));
  state.set_faults(record.faults.bits());
  state.set_limiters(record.limiters.bits());
  Doubles* stiffness = state.mutable_stiffness_in_effect();
  stiffness->Clear();
  for (const double k : record.input.settings.stiffness) stiffness->Add(record.gain * k);
  state.set_projection(static_cast<v1::ProjectionStatus>(record.projection));
  state.set_condition(record.condition);
  state.set_lease_epoch(stamp.lease_epoch);
  state.set_mode(static_cast<v1::ProxyMode>(record.proxy_mode));
  if (record.certificate.status != core::CertificateStatus::kOff) {
    v1::CertificateState& certificate = *state.mutable_certificate();
    certificate.set_status(static_cast<v1::CertificateStatus>(record.certificate.status));
    certificate.set_margin(record.certificate.margin);
    certificate.set_block(static_cast<std::uint32_t>(record.certificate.block));
  } else {
    state.clear_certificate();
  }
  to_actuators(record, state);
}

void to_proto(const std::vector<core::CouplingBlock>& blocks, v1::DeviceState& state) {
  state.clear_coupling_metric();
  for (const core::CouplingBlock& block : blocks) {
    v1::CouplingBlock& message = *state.add_coupling_metric();
    message.set_coordinates(static_cast<std::uint32_t>(block.coordinates));
    message.mutable_lower()->Add(block.lower.begin(), block.lower.end());
  }
}

v1::Event to_proto(const DeviceEvent& event) {
  v1::Event message;
  message.set_kind(static_cast<v1::Event::Kind>(event.kind));
  message.set_server_time_ns(event.time.time_since_epoch().count());
  message.set_reason(event.reason);
  message.set_message(event.message);
  message.set_state(static_cast<v1::DeviceStateName>(event.state));
  message.set_lease_epoch(event.lease_epoch);
  return message;
}

v1::UpdateSettingsResponse to_proto(const SettingsAnswer& answer) {
  v1::UpdateSettingsResponse message;
  const core::RenderSettings& applied = answer.applied;
  copy(applied.stiffness, message.mutable_stiffness());
  copy(applied.damping, message.mutable_damping());
  copy(applied.force_limit, message.mutable_force_limit());
  copy(applied.slew_limit, message.mutable_slew_limit());
  message.set_renderer(static_cast<v1::Renderer>(applied.renderer));
  message.set_direction_guard(applied.direction_guard);
  for (const SettingsClamp& clamp : answer.clamped) {
    auto* entry = message.add_clamped();
    entry->set_field(clamp.field);
    entry->set_asked(clamp.asked);
    entry->set_applied(clamp.applied);
    entry->set_why(clamp.why);
  }
  return message;
}

v1::GetServerInfoResponse to_proto(const ServerFacts& facts) {
  v1::GetServerInfoResponse info;
  info.set_version(facts.version);
  info.set_protocol("haptic.v1");
  info.set_scene(facts.scene);
  v1::RealtimeGrant& realtime = *info.mutable_realtime();
  realtime.set_requested(facts.realtime.requested);
  realtime.set_sched_fifo(facts.realtime.sched_fifo);
  realtime.set_priority(facts.realtime.priority);
  realtime.set_memory_locked(facts.realtime.memory_locked);
  realtime.set_timer_slack(facts.realtime.timer_slack);
  realtime.set_cpu(facts.realtime.cpu);
  realtime.set_grade(facts.realtime.grade);
  realtime.set_explanation(facts.realtime.explanation);
  v1::LoopStatistics& loop = *info.mutable_loop();
  loop.set_ticks(facts.loop.ticks);
  loop.set_skipped(facts.loop.skipped);
  loop.set_lateness_p50_us(facts.loop.lateness_p50_us);
  loop.set_lateness_p99_us(facts.loop.lateness_p99_us);
  loop.set_lateness_max_us(facts.loop.lateness_max_us);
  loop.set_tick_p50_us(facts.loop.tick_p50_us);
  loop.set_tick_p99_us(facts.loop.tick_p99_us);
  loop.set_records_dropped(facts.loop.records_dropped);
  loop.set_paced_by_sample(facts.loop.paced_by_sample);
  loop.set_paced_by(facts.loop.paced_by);
  set(*info.mutable_uptime(), facts.uptime);
  return info;
}

v1::Device describe(const DeviceSessions& device, core::Duration period) {
  v1::Device message;
  const hw::DeviceInfo& info = device.unit().device().info();
  const core::PipelineConfig& config = device.unit().config();
  message.set_name(device.name());
  message.set_kind(info.kind);
  message.set_model(info.model);
  message.set_serial(info.serial);
  message.set_moves(info.moves);
  message.set_calibrated(info.calibrated);
  message.set_measures_force(info.measures_force);
  Eigen::Index actuated = 0;
  for (const core::DofSpec& spec : info.dofs) {
    auto* dof = message.add_dofs();
    dof->set_name(spec.name);
    dof->set_unit(unit_name(spec.unit));
    dof->set_actuated(spec.actuated);
    dof->set_lower(spec.lower);
    dof->set_upper(spec.upper);
    if (!spec.actuated) continue;
    if (actuated < config.device.max_effort.size()) {
      dof->set_max_effort(config.device.max_effort[actuated]);
    }
    ++actuated;
  }
  for (const core::Coordinate& coordinate : config.kinematics->space().coordinates()) {
    auto* entry = message.add_coordinates();
    entry->set_name(coordinate.name);
    const bool quaternion = coordinate.kind == core::CoordinateKind::kQuaternion;
    entry->set_unit(quaternion ? "1" : unit_name(coordinate.unit));
    entry->set_kind(kind_name(coordinate.kind));
  }
  copy(config.scene.stiffness, message.mutable_stiffness_limit());
  copy(config.scene.damping, message.mutable_damping_limit());
  copy(config.scene.force_limit, message.mutable_force_limit());
  copy(config.scene.slew_limit, message.mutable_slew_limit());
  copy(config.scene.engage_window, message.mutable_engage_window());
  message.set_loop_rate_hz(1.0 / core::seconds(period));
  const core::TickRecord newest = device.newest();
  message.set_state(static_cast<v1::DeviceStateName>(newest.state));
  message.set_faults(newest.faults.bits());
  message.set_controller(device.controller());
  message.set_renderer(static_cast<v1::Renderer>(device.settings().renderer));
  message.set_observers(device.observers());
  if (const DeviceTracker* const tracker = device.tracker()) {
    message.set_wants_tracker(true);
    message.set_tracker(tracker->client_name());
  }
  return message;
}

void to_proto(const wire::PathKeys& keys, const UdpPort& port, v1::UdpPath& message) {
  const auto bytes = [](const auto& array) { return std::string(array.begin(), array.end()); };
  message.set_host(port.host());
  message.set_port(port.port());
  message.set_path_id(keys.path_id);
  message.set_up_key(bytes(keys.up.key));
  message.set_up_salt(bytes(keys.up.salt));
  message.set_down_key(bytes(keys.down.key));
  message.set_down_salt(bytes(keys.down.salt));
}

namespace {

/// A coupling metric in which no block is empty.
std::vector<core::CouplingBlock> full_coupling(const core::PipelineConfig& config) {
  const core::ProjectionModel model(*config.kinematics, config.projection);
  std::vector<core::CouplingBlock> blocks = core::coupling_blocks(model, {}, {}, 1.0);
  for (core::CouplingBlock& block : blocks) {
    const auto n = static_cast<std::size_t>(block.coordinates);
    block.lower.assign(n * (n + 1) / 2, 1.0);
  }
  return blocks;
}

}  // namespace

std::size_t largest_state(const core::PipelineConfig& config, bool coupled) {
  // Vectors of numbers that are not 0 and every other field at its longest.
  core::TickRecord record;
  const auto n_q = config.kinematics->layout().n_q(), n_a = config.kinematics->layout().n_a(),
             n_x = config.kinematics->space().n_x();
  record.q = record.q_star = core::VecQ::Ones(n_q);
  record.q_a_dot = record.tau_a = record.tau_elastic = core::VecA::Ones(n_a);
  record.input.settings.stiffness = core::VecA::Ones(n_a);
  record.x = record.x_probe = core::VecX::Ones(n_x);
  record.active_planes = ~std::uint32_t{0};
  record.input.device.sample.tau_measured = core::VecA::Ones(n_a);
  record.input.device.sample.q = 2.0 * record.q;  // refused: told as `reading` too
  if (!config.ratings.empty()) record.temperature_c = core::VecA::Ones(n_a);
  record.drive = core::VecA::Ones(n_a);
  for (core::LimiterSet& limiters : record.actuator_limiters) {
    limiters.set(core::Limiter::kDriveLimit);  // the longest number
  }
  record.tracker.on = config.tracker.has_value();
  if (config.tracker) record.tracker.first_dof = config.tracker->first_dof;
  record.tracker.seq = ~std::uint64_t{0};
  record.tracker.age = core::Duration::max();
  record.passivity.on = config.passivity.enabled();
  record.passivity.tank = record.passivity.storage = record.passivity.scale = 1.0;
  record.passivity.observed = record.passivity.alpha = 1.0;
  if (config.passivity_certificate) {
    record.certificate = {core::CertificateStatus::kNoStiffness, 31, 1.0};
  }
  v1::DeviceState state;
  to_proto(record, {Carrier::kUdp, 0}, state);
  if (coupled) to_proto(full_coupling(config), state);
  constexpr std::size_t kScalars = 120;  // 4 of 64 bits, 9 of 32, 2 doubles, with their tags
  return state.ByteSizeLong() + kScalars;
}

ProxyCandidate from_proto(const v1::ProxySample& sample, std::uint32_t epoch, Carrier carrier) {
  ProxyCandidate candidate;
  candidate.carrier = carrier;
  candidate.epoch = epoch;
  candidate.seq = sample.seq();
  if (sample.mode() == v1::PROXY_MODE_HELD) candidate.mode = core::ProxyMode::kHeld;
  if (sample.mode() == v1::PROXY_MODE_FREE) candidate.mode = core::ProxyMode::kFree;
  if (sample.mode() == v1::PROXY_MODE_PLANES) candidate.mode = core::ProxyMode::kPlanes;
  candidate.plane_count = sample.planes_size();
  const int taken = std::min(candidate.plane_count, static_cast<int>(candidate.planes.size()));
  for (int i = 0; i < taken; ++i) {
    const v1::Plane& plane = sample.planes(i);
    candidate.planes[static_cast<std::size_t>(i)] = {plane.normal().data(), plane.normal_size(),
                                                     plane.offset()};
  }
  candidate.valid_for = std::chrono::microseconds(sample.valid_for_us());
  candidate.position = sample.position().data();
  candidate.position_size = sample.position_size();
  return candidate;
}

PoseCandidate from_proto(const v1::TrackerSample& sample) {
  PoseCandidate candidate;
  candidate.seq = sample.seq();
  candidate.valid_for = std::chrono::microseconds(sample.valid_for_us());
  candidate.position = sample.position().data();
  candidate.position_size = sample.position_size();
  candidate.orientation = sample.orientation().data();
  candidate.orientation_size = sample.orientation_size();
  return candidate;
}

LeaseRequest from_proto(const v1::OpenSession& open, std::string session_id,
                        std::string client_name) {
  LeaseRequest request;
  request.session_id = std::move(session_id);
  request.client_name = std::move(client_name);
  request.nominal_rate_hz = open.nominal_rate_hz();
  if (open.priority() != v1::PRIORITY_UNSPECIFIED) {
    request.priority = static_cast<Priority>(open.priority());
  }
  request.resumable = open.resumable();
  request.resume = open.resume();
  if (open.has_fresh_end()) request.fresh_end = duration(open.fresh_end());
  if (open.has_hold_end()) request.hold_end = duration(open.hold_end());
  if (open.has_fade_end()) request.fade_end = duration(open.fade_end());
  return request;
}

Outcome<SettingsRequest> from_proto(const v1::UpdateSettingsRequest& message) {
  SettingsRequest request;
  request.stiffness = values(message.stiffness());
  request.damping = values(message.damping());
  request.force_limit = values(message.force_limit());
  request.slew_limit = values(message.slew_limit());
  if (message.renderer() < v1::RENDERER_UNSPECIFIED ||
      message.renderer() > v1::RENDERER_SUBSPACE_EXACT) {
    return Refusal{Refusal::Code::kInvalid, "INVALID_ARGUMENT",
                   "renderer = " + std::to_string(message.renderer()) + ": must be 1..4",
                   "renderer"};
  }
  if (message.renderer() != v1::RENDERER_UNSPECIFIED) {
    request.renderer = static_cast<core::RendererKind>(message.renderer());
  }
  if (message.has_direction_guard()) request.direction_guard = message.direction_guard();
  return request;
}

}  // namespace haptic::server
