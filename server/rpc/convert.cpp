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
  message.set_state(static_cast<v1::DeviceStateName>(newest.life.state));
  message.set_faults(newest.faults().bits());
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
