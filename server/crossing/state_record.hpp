#pragma once
/// The state of a device after one tick, flat: what of a TickRecord the front may see. A field of
/// the state has its whole way in this file: where it comes from, what crosses, and where it goes.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <initializer_list>

#include "haptic/core/tick/tick_record.hpp"

namespace haptic::server {

/// Up to N numbers. `count` may be above N if they came off the wire: then they are refused.
template <std::size_t N>
struct Numbers {
  std::uint32_t count{0};
  std::array<double, N> value{};

  Numbers() = default;
  Numbers(const double* from, std::size_t size) : count(static_cast<std::uint32_t>(size)) {
    std::copy_n(from, std::min(size, N), value.begin());
  }
  Numbers(std::initializer_list<double> list) : Numbers(list.begin(), list.size()) {}

  [[nodiscard]] const double* begin() const noexcept { return value.data(); }
  [[nodiscard]] const double* end() const noexcept {
    return begin() + std::min<std::size_t>(count, N);
  }
};
using Values = Numbers<core::kMaxQ>;       ///< one per DoF, or per actuated DoF
using Coordinates = Numbers<core::kMaxX>;  ///< one per virtual coordinate

/// Which way a sample came.
enum class Carrier : std::uint8_t { kNone = 0, kGrpc = 1, kUdp = 2, kWebSocket = 3 };
inline constexpr std::size_t kCarriers = 4;

/// Symbols and units as in core::TickRecord.
struct StateRecord {
  std::uint64_t tick{0};
  core::TimePoint now{};
  core::Duration dt{0};        ///< since the previous tick
  core::Duration lateness{0};  ///< of the loop
  std::uint32_t skipped{0};    ///< deadlines passed over since the last tick

  core::LifecycleState state{core::LifecycleState::kInit};
  bool lost{false};  ///< force was given up in this tick
  core::FaultSet faults{};
  core::LimiterSet limiters{};
  double gain{0.0}, damping_gain{0.0};

  bool lease_held{false};
  std::uint32_t tenure{0};          ///< the lease's number for the loop
  std::uint32_t lease_epoch{0};     ///< the lease's number for clients
  Carrier carrier{Carrier::kNone};  ///< of the proxy in use
  core::ProxyMode mode{core::ProxyMode::kNone};
  core::Staleness staleness{core::Staleness::kLost};
  std::uint64_t proxy_seq{0};
  core::Duration proxy_age{0};
  std::uint32_t active_planes{0};
  double unexplained{0.0};

  std::uint64_t sample_seq{0};   ///< of the device; 0: none so far
  core::Duration sample_age{0};  ///< of that sample
  Values q{}, q_a_dot{};
  Values reading{};       ///< what the device said, if it was refused; else empty
  Values tau_measured{};  ///< empty if the device measures none
  Coordinates x_probe{}, x{};
  Values q_star{}, tau_elastic{}, tau_damping{}, tau_a{};
  Values error_bound{};    ///< empty: nothing is known of it
  Values drive{};          ///< what goes to the device instead of tau_a; empty: tau_a does
  Values temperature_c{};  ///< empty if no winding has a model
  Values stiffness{};      ///< in effect, before the gain
  core::DeratingReason derating{core::DeratingReason::kNone};
  core::Duration derating_delay{0};
  std::array<std::uint32_t, core::kMaxQ> actuator_limiters{};  ///< n_a of them are set

  core::ProjectionStatus projection{core::ProjectionStatus::kNone};
  double residual{0.0}, condition{0.0};
  core::PassivityRecord passivity{};
  core::TrackerRecord tracker{};
};

template <typename Vector>
auto flat(const Vector& from) {
  constexpr auto kMost = static_cast<std::size_t>(Vector::MaxRowsAtCompileTime);
  return Numbers<kMost>(from.data(), static_cast<std::size_t>(from.size()));
}

/// What the device said, if it was refused.
inline Values refused_reading(const core::TickRecord& record) {
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

/// `carrier`: of the proxy in use; `lease_epoch`: of its lease as clients know it. The loop knows
/// neither.
[[nodiscard]] inline StateRecord state_record(const core::TickRecord& record,
                                              Carrier carrier = Carrier::kNone,
                                              std::uint32_t lease_epoch = 0) {
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
  s.unexplained = record.anchor.unexplained;

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
  s.error_bound = flat(record.effort.error_bound);
  s.drive = flat(record.effort.drive.size() > 0 ? record.effort.drive : record.effort.position);
  s.temperature_c = flat(record.effort.temperature_c);
  const bool derated = record.derating.reason != core::DeratingReason::kNone;
  s.stiffness = flat(derated ? record.derating.stiffness : in.settings.stiffness);
  s.derating = record.derating.reason;
  s.derating_delay = record.derating.delay;
  for (std::size_t i = 0; i < s.actuator_limiters.size(); ++i) {
    s.actuator_limiters[i] = record.effort.actuator_limiters[i].bits();
  }

  s.projection = record.anchor.projection;
  s.residual = record.anchor.residual;
  s.condition = record.anchor.condition;
  s.passivity = record.effort.passivity;
  s.tracker = record.sensed.tracker;
  return s;
}

template <std::size_t N, typename Doubles>
void copy(const Numbers<N>& from, Doubles* to) {
  to->Clear();
  to->Add(from.begin(), from.end());
}

inline std::uint64_t whole_microseconds(core::Duration age) {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(age).count();
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, us));
}

template <typename State>
void to_proto(const core::PassivityRecord& record, State& state) {
  state.set_tank(record.tank);
  state.set_storage(record.storage);
  state.set_scale(record.scale);
  state.set_observed(record.observed);
  state.set_alpha(record.alpha);
}

template <typename State>
void to_proto(const core::TrackerRecord& record, State& state) {
  state.set_seq_used(record.seq);
  state.set_age_us(whole_microseconds(record.age));
  state.set_staleness(static_cast<decltype(state.staleness())>(record.level));
}

/// One per actuated DoF, or none if none acted.
template <typename State>
void to_limiters(const StateRecord& record, State& state) {
  state.clear_actuator_limiters();
  const auto begin = record.actuator_limiters.begin();
  const auto end = begin + record.tau_a.count;
  if (std::any_of(begin, end, [](std::uint32_t bits) { return bits != 0; })) {
    state.mutable_actuator_limiters()->Add(begin, end);
  }
}

/// The record as a v1::DeviceState: a template, so that this header needs no protobuf.
template <typename State>
void write(const StateRecord& record, State& state) {
  state.set_seq(record.tick);
  state.set_server_time_ns(record.now.time_since_epoch().count());
  copy(record.q, state.mutable_q());
  copy(record.q_a_dot, state.mutable_q_dot());
  copy(record.x_probe, state.mutable_x_probe());
  copy(record.x, state.mutable_x());
  state.set_active_planes(record.active_planes);
  state.set_unexplained(record.unexplained);
  state.clear_passivity();
  if (record.passivity.on) to_proto(record.passivity, *state.mutable_passivity());
  copy(record.q_star, state.mutable_q_star());
  copy(record.tau_a, state.mutable_tau_a());
  copy(record.tau_elastic, state.mutable_tau_elastic());
  copy(record.error_bound, state.mutable_error_bound());
  state.set_proxy_seq_used(record.proxy_seq);
  state.set_proxy_age_us(whole_microseconds(record.proxy_age));
  state.clear_tracker();
  if (record.tracker.on) to_proto(record.tracker, *state.mutable_tracker());
  state.set_staleness(static_cast<decltype(state.staleness())>(record.staleness));
  state.set_gain(record.gain);
  state.set_transport(static_cast<decltype(state.transport())>(record.carrier));
  state.set_state(static_cast<decltype(state.state())>(record.state));
  state.set_faults(record.faults.bits());
  state.set_limiters(record.limiters.bits());
  state.clear_stiffness_in_effect();
  for (const double k : record.stiffness) state.add_stiffness_in_effect(record.gain * k);
  state.set_derating(static_cast<decltype(state.derating())>(record.derating));
  state.set_derating_delay_us(whole_microseconds(record.derating_delay));
  state.set_projection(static_cast<decltype(state.projection())>(record.projection));
  state.set_condition(record.condition);
  state.set_lease_epoch(record.lease_epoch);
  state.set_mode(static_cast<decltype(state.mode())>(record.mode));
  copy(record.tau_measured, state.mutable_tau_measured());
  copy(record.reading, state.mutable_reading());
  copy(record.temperature_c, state.mutable_temperature_c());
  copy(record.drive, state.mutable_drive());
  to_limiters(record, state);
}

}  // namespace haptic::server
