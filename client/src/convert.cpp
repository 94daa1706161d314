#include "convert.hpp"

#include "convert_state.hpp"

namespace haptic::client {

DeviceState to_state(const v1::DeviceState& message) {
  DeviceState state;
  read(message, state);
  state.received = std::chrono::steady_clock::now();
  return state;
}

std::chrono::nanoseconds to_duration(const google::protobuf::Duration& message) {
  return std::chrono::seconds(message.seconds()) + std::chrono::nanoseconds(message.nanos());
}

Event to_event(const v1::Event& m) {
  return {static_cast<unsigned>(m.kind()), m.reason(), m.message(),
          static_cast<Lifecycle>(m.state()), m.server_time_ns()};
}

DeviceInfo to_info(const v1::Device& m) {
  DeviceInfo d;
  d.name = m.name();
  d.kind = m.kind();
  d.model = m.model();
  d.serial = m.serial();
  d.moves = m.moves();
  d.calibrated = m.calibrated();
  d.measures_force = m.measures_force();
  for (const auto& dof : m.dofs()) {
    d.dofs.push_back(
        {dof.name(), dof.unit(), dof.actuated(), dof.lower(), dof.upper(), dof.max_effort()});
  }
  for (const auto& c : m.coordinates()) d.coordinates.push_back({c.name(), c.unit(), c.kind()});
  d.stiffness_limit = to_vector(m.stiffness_limit());
  d.damping_limit = to_vector(m.damping_limit());
  d.force_limit = to_vector(m.force_limit());
  d.slew_limit = to_vector(m.slew_limit());
  d.engage_window = to_vector(m.engage_window());
  d.loop_rate_hz = m.loop_rate_hz();
  d.state = static_cast<Lifecycle>(m.state());
  d.faults = m.faults();
  d.controller = m.controller();
  d.renderer = static_cast<Renderer>(m.renderer());
  d.observers = m.observers();
  d.wants_tracker = m.wants_tracker();
  d.unguarded.assign(m.unguarded().begin(), m.unguarded().end());
  d.tracker = m.tracker();
  return d;
}

ServerInfo to_info(const v1::GetServerInfoResponse& m) {
  ServerInfo s;
  s.version = m.version();
  s.protocol = m.protocol();
  s.scene = m.scene();
  s.realtime_grade = m.realtime().grade();
  s.realtime_explanation = m.realtime().explanation();
  s.insecure.assign(m.insecure().begin(), m.insecure().end());
  s.ticks = m.loop().ticks();
  s.skipped_ticks = m.loop().skipped();
  s.records_dropped = m.loop().records_dropped();
  s.lateness_p50_us = m.loop().lateness_p50_us();
  s.lateness_p99_us = m.loop().lateness_p99_us();
  s.lateness_max_us = m.loop().lateness_max_us();
  s.tick_p50_us = m.loop().tick_p50_us();
  s.tick_p99_us = m.loop().tick_p99_us();
  s.paced_by = m.loop().paced_by();
  s.paced_by_sample = m.loop().paced_by_sample();
  s.sessions = m.sessions();
  s.uptime = to_duration(m.uptime());
  return s;
}

v1::UpdateSettingsRequest to_request(const Settings& settings) {
  v1::UpdateSettingsRequest m;
  m.mutable_stiffness()->Add(settings.stiffness.begin(), settings.stiffness.end());
  m.mutable_damping()->Add(settings.damping.begin(), settings.damping.end());
  m.mutable_force_limit()->Add(settings.force_limit.begin(), settings.force_limit.end());
  m.mutable_slew_limit()->Add(settings.slew_limit.begin(), settings.slew_limit.end());
  m.set_renderer(static_cast<v1::Renderer>(settings.renderer));
  if (settings.direction_guard) m.set_direction_guard(*settings.direction_guard);
  return m;
}

AppliedSettings to_settings(const v1::UpdateSettingsResponse& m) {
  AppliedSettings s;
  s.applied = {to_vector(m.stiffness()),
               to_vector(m.damping()),
               to_vector(m.force_limit()),
               to_vector(m.slew_limit()),
               static_cast<Renderer>(m.renderer()),
               m.direction_guard()};
  for (const auto& clamp : m.clamped()) {
    s.clamped.push_back({clamp.field(), clamp.asked(), clamp.applied(), clamp.why()});
  }
  return s;
}

}  // namespace haptic::client
