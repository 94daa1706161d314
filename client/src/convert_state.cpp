#include "convert.hpp"

namespace haptic::client {
namespace {

PassivityState to_passivity(const v1::PassivityState& m) {
  return {m.tank(), m.storage(), m.scale(), m.observed(), m.alpha()};
}

TrackerState to_tracker(const v1::TrackerState& m) {
  return {m.seq_used(), std::chrono::microseconds(m.age_us()),
          static_cast<Staleness>(m.staleness())};
}

CertificateState to_certificate(const v1::CertificateState& m) {
  return {static_cast<CertificateState::Status>(m.status()), m.margin(), m.block()};
}

}  // namespace

DeviceState to_state(const v1::DeviceState& m) {
  DeviceState s;
  s.seq = m.seq();
  s.server_time_ns = m.server_time_ns();
  s.state = static_cast<Lifecycle>(m.state());
  s.mode = static_cast<Mode>(m.mode());
  s.proxy_seq_used = m.proxy_seq_used();
  s.proxy_age = std::chrono::microseconds(m.proxy_age_us());
  s.staleness = static_cast<Staleness>(m.staleness());
  s.gain = m.gain();
  s.carrier = static_cast<Carrier>(m.transport());
  s.lease_epoch = m.lease_epoch();
  s.q = to_vector(m.q());
  s.q_dot = to_vector(m.q_dot());
  s.x_probe = to_vector(m.x_probe());
  s.x = to_vector(m.x());
  s.q_star = to_vector(m.q_star());
  s.tau_a = to_vector(m.tau_a());
  s.tau_elastic = to_vector(m.tau_elastic());
  s.stiffness_in_effect = to_vector(m.stiffness_in_effect());
  s.tau_measured = to_vector(m.tau_measured());
  s.drive = to_vector(m.drive());
  s.temperature_c = to_vector(m.temperature_c());
  s.reading = to_vector(m.reading());
  s.projection = static_cast<unsigned>(m.projection());
  s.condition = m.condition();
  s.active_planes = m.active_planes();
  s.faults = m.faults();
  s.limiters = m.limiters();
  s.actuator_limiters = to_vector(m.actuator_limiters());
  if (m.has_passivity()) s.passivity = to_passivity(m.passivity());
  if (m.has_tracker()) s.tracker = to_tracker(m.tracker());
  if (m.has_certificate()) s.certificate = to_certificate(m.certificate());
  for (const v1::CouplingBlock& block : m.coupling_metric()) {
    s.coupling_metric.push_back({block.coordinates(), to_vector(block.lower())});
  }
  s.received = std::chrono::steady_clock::now();
  s.message = m.SerializeAsString();
  return s;
}

}  // namespace haptic::client
