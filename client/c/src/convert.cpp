#include "convert.hpp"

#include <cmath>

#include "structs.hpp"

namespace haptic::c {

namespace {

/// `value` as an enumerator from 0 to `last`.
template <typename Enum>
Enum enumerator(const char* name, std::int32_t value, Enum last) {
  if (value < 0 || value > static_cast<std::int32_t>(last)) {
    refuse(std::string(name) + " = " + std::to_string(value) + ", must be 0 to " +
           std::to_string(static_cast<int>(last)));
  }
  return static_cast<Enum>(value);
}

void at_most(const char* name, std::uint32_t count, std::size_t most) {
  if (count > most) {
    refuse(std::string(name) + " = " + std::to_string(count) + ", must be at most " +
           std::to_string(most));
  }
}

}  // namespace

haptic_device to_device(const client::DeviceInfo& device) {
  haptic_device to{};
  write_text(device.name, to.name);
  write_text(device.kind, to.kind);
  write_text(device.model, to.model);
  write_text(device.controller, to.controller);
  to.moves = device.moves ? 1 : 0;
  to.wants_tracker = device.wants_tracker ? 1 : 0;
  to.state = static_cast<std::int32_t>(device.state);
  to.faults = device.faults;
  to.loop_rate_hz = device.loop_rate_hz;
  to.dof_count = static_cast<std::uint32_t>(device.dofs.size());
  to.coordinate_count = static_cast<std::uint32_t>(device.coordinates.size());
  for (std::size_t i = 0; i < device.dofs.size(); ++i) {
    const client::DegreeOfFreedom& dof = device.dofs[i];
    to.actuated_count += dof.actuated ? 1U : 0U;
    if (i >= HAPTIC_MAX_DOFS) continue;
    write_text(dof.name, to.dofs[i].name);
    write_text(dof.unit, to.dofs[i].unit);
    to.dofs[i].actuated = dof.actuated ? 1 : 0;
    to.dofs[i].lower = dof.lower;
    to.dofs[i].upper = dof.upper;
    to.dofs[i].max_effort = dof.max_effort;
  }
  const std::size_t coordinates =
      std::min<std::size_t>(device.coordinates.size(), HAPTIC_MAX_COORDINATES);
  for (std::size_t i = 0; i < coordinates; ++i) {
    write_text(device.coordinates[i].name, to.coordinates[i].name);
    write_text(device.coordinates[i].unit, to.coordinates[i].unit);
    write_text(device.coordinates[i].kind, to.coordinates[i].kind);
  }
  return to;
}

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
  write_list(state.temperature_c, to.temperature_c);
  to.projection = static_cast<std::int32_t>(state.projection);
  to.derating = static_cast<std::int32_t>(state.derating);
  to.derating_delay_us = static_cast<std::uint64_t>(state.derating_delay.count());
  to.condition = state.condition;
  to.unexplained = state.unexplained;
  return to;
}

haptic_settings to_settings(const client::AppliedSettings& settings) {
  haptic_settings to{};
  const client::Settings& applied = settings.applied;
  write_list(applied.stiffness, to.stiffness);
  write_list(applied.damping, to.damping);
  write_list(applied.force_limit, to.force_limit);
  write_list(applied.slew_limit, to.slew_limit);
  to.renderer = static_cast<std::int32_t>(applied.renderer);
  if (applied.direction_guard) to.direction_guard = *applied.direction_guard ? 1 : 2;
  to.clamped = static_cast<std::uint32_t>(settings.clamped.size());
  return to;
}

client::Settings to_settings(const haptic_settings& settings) {
  client::Settings to{
      .stiffness = read_list(settings.stiffness, "wanted->stiffness"),
      .damping = read_list(settings.damping, "wanted->damping"),
      .force_limit = read_list(settings.force_limit, "wanted->force_limit"),
      .slew_limit = read_list(settings.slew_limit, "wanted->slew_limit"),
      .renderer = enumerator("wanted->renderer", settings.renderer, client::Renderer::kPerContact)};
  const int guard = enumerator("wanted->direction_guard", settings.direction_guard, 2);
  if (guard != 0) to.direction_guard = guard == 1;
  return to;
}

client::SessionOptions to_options(const haptic_session_options& options) {
  client::SessionOptions to;
  to.device = text_or(options.device, "");
  to.client_name = text_or(options.client_name, to.client_name.c_str());
  to.observer = options.observer != 0;
  if (options.priority != 0) {
    to.priority = enumerator("options->priority", options.priority, client::Priority::kOperator);
  }
  if (options.nominal_rate_hz != 0.0) to.nominal_rate_hz = options.nominal_rate_hz;
  to.state_rate_hz = options.state_rate_hz;
  if (options.stream_only != 0) to.carriers = client::Carriers::kGrpcOnly;
  if (options.reconnect != 0) to.reconnect = client::Reconnect::kWithBackoff;
  to.re_engage = options.re_engage != 0;
  to.derive_planes = options.derive_planes != 0;
  if (options.timeout_ms != 0) to.timeout = std::chrono::milliseconds(options.timeout_ms);
  return to;
}

client::Plane to_plane(const haptic_plane& plane, std::size_t coordinates) {
  at_most("plane.curvature_count", plane.curvature_count, std::size(plane.curvature));
  at_most("plane.object_direction_count", plane.object_direction_count,
          std::size(plane.object_direction));
  client::Plane to;
  to.normal.assign(plane.normal, plane.normal + coordinates);
  to.offset = plane.offset;
  to.compliance = plane.compliance;
  to.velocity = plane.velocity;
  to.curvature.assign(plane.curvature, plane.curvature + plane.curvature_count);
  to.first_coordinate = plane.first_coordinate;
  to.id = plane.id;
  to.mass = plane.mass;
  to.damping = plane.damping;
  to.ground_stiffness = plane.ground_stiffness;
  to.load = plane.load;
  if (plane.has_uncertainty != 0) to.uncertainty = plane.uncertainty;
  to.object = plane.object;
  to.object_direction.assign(plane.object_direction,
                             plane.object_direction + plane.object_direction_count);
  return to;
}

std::vector<double> to_position(const double* x, std::size_t count, std::size_t coordinates) {
  given(x, "x");
  if (count != coordinates) {
    refuse("count = " + std::to_string(count) + ", must be " + std::to_string(coordinates) +
           ", one value per coordinate of the device");
  }
  std::vector<double> position(x, x + count);
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(x[i])) {
      refuse("x[" + std::to_string(i) + "] = " + std::to_string(x[i]) + ", must be finite");
    }
  }
  return position;
}

}  // namespace haptic::c
