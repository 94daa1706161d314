#include "server/state/state_record.hpp"

namespace haptic::server {
namespace {

template <typename Vector>
auto flat(const Vector& from) {
  constexpr auto kMost = static_cast<std::size_t>(Vector::MaxRowsAtCompileTime);
  return Numbers<kMost>(from.data(), static_cast<std::size_t>(from.size()));
}

/// What the device said, if it was refused.
Values refused_reading(const core::TickRecord& record) {
  core::VecQ reading = record.input.device.sample.q;
  if (reading.size() != record.sensed.q.size()) return {};
  if (record.sensed.tracker.on) {
    // What the device says of a tracked palm is not looked at.
    constexpr auto kDofs = static_cast<Eigen::Index>(core::kPalmDofs);
    reading.segment<kDofs>(record.sensed.tracker.first_dof) =
        record.sensed.q.segment<kDofs>(record.sensed.tracker.first_dof);
  }
  return reading == record.sensed.q ? Values{} : flat(reading);
}

}  // namespace

StateRecord state_record(const core::TickRecord& record, Carrier carrier,
                         std::uint32_t lease_epoch) {
  const core::TickInput& in = record.input;
  StateRecord s;
  s.tick = record.beat.tick;
  s.now = in.now;
  s.dt = record.beat.dt;
  s.lateness = in.loop.lateness;
  s.skipped = in.loop.skipped;

  s.state = record.life.state;
  s.lost = record.life.lost;
  s.faults = record.faults();
  s.limiters = record.limiters();
  s.gain = record.life.gain;
  s.damping_gain = record.life.damping_gain;

  s.lease_held = in.command.lease_held;
  s.tenure = in.command.tenure;
  s.lease_epoch = lease_epoch;
  s.carrier = carrier;
  s.mode = record.proxy.mode;
  s.staleness = record.proxy.level;
  s.proxy_seq = record.proxy.seq;
  s.proxy_age = record.proxy.age;
  s.active_planes = record.anchor.active_planes;

  s.sample_seq = in.device.sample.seq;
  s.sample_age = in.now - in.device.sample.time;
  s.q = flat(record.sensed.q);
  s.q_a_dot = flat(record.sensed.q_a_dot);
  s.reading = refused_reading(record);
  s.tau_measured = flat(in.device.sample.tau_measured);
  s.x_probe = flat(record.anchor.x_probe);
  s.x = flat(record.anchor.x);
  s.q_star = flat(record.effort.q_star);
  s.tau_elastic = flat(record.effort.tau_elastic);
  s.tau_damping = flat(record.effort.tau_damping);
  s.tau_a = flat(record.effort.tau_a);
  s.drive = flat(record.effort.drive.size() > 0 ? record.effort.drive : record.effort.position);
  s.temperature_c = flat(record.effort.temperature_c);
  s.stiffness = flat(in.settings.stiffness);
  for (std::size_t i = 0; i < s.actuator_limiters.size(); ++i) {
    s.actuator_limiters[i] = record.effort.actuator_limiters[i].bits();
  }

  s.projection = record.anchor.projection;
  s.residual = record.anchor.residual;
  s.condition = record.anchor.condition;
  s.certificate = record.anchor.certificate;
  s.passivity = record.effort.passivity;
  s.tracker = record.sensed.tracker;
  return s;
}

}  // namespace haptic::server
