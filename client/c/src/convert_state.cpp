#include "convert.hpp"
#include "structs.hpp"

namespace haptic::c {

haptic_state to_state(const client::DeviceState& state) {
  haptic_state to{};
  to.seq = state.seq;
  to.server_time_ns = state.server_time_ns;
  to.proxy_seq_used = state.proxy_seq_used;
  to.proxy_age_us = static_cast<std::uint64_t>(state.proxy_age.count());
  to.state = static_cast<std::int32_t>(state.state);
  to.mode = static_cast<std::int32_t>(state.mode);
  to.staleness = static_cast<std::int32_t>(state.staleness);
  to.carrier = static_cast<std::int32_t>(state.carrier);
  to.lease_epoch = state.lease_epoch;
  to.faults = state.faults;
  to.limiters = state.limiters;
  to.active_planes = state.active_planes;
  to.gain = state.gain;
  write_list(state.q, to.q);
  write_list(state.q_dot, to.q_dot);
  write_list(state.x_probe, to.x_probe);
  write_list(state.x, to.x);
  write_list(state.q_star, to.q_star);
  write_list(state.tau_a, to.tau_a);
  write_list(state.tau_elastic, to.tau_elastic);
  write_list(state.error_bound, to.error_bound);
  write_list(state.stiffness_in_effect, to.stiffness_in_effect);
  write_list(state.tau_measured, to.tau_measured);
  write_list(state.drive, to.drive);
  write_list(state.temperature_c, to.temperature_c);
  write_list(state.reading, to.reading);
  write_list(state.actuator_limiters, to.actuator_limiters);
  if (state.passivity) {
    const client::PassivityState& energy = *state.passivity;
    to.passivity = {1, energy.tank, energy.storage, energy.scale, energy.observed, energy.alpha};
  }
  if (state.tracker) {
    to.tracker = {1, static_cast<std::int32_t>(state.tracker->staleness), state.tracker->seq_used,
                  static_cast<std::uint64_t>(state.tracker->age.count())};
  }
  to.projection = static_cast<std::int32_t>(state.projection);
  to.derating = static_cast<std::int32_t>(state.derating);
  to.derating_delay_us = static_cast<std::uint64_t>(state.derating_delay.count());
  to.condition = state.condition;
  to.unexplained = state.unexplained;
  return to;
}

}  // namespace haptic::c
