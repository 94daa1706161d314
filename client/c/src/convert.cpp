#include "convert.hpp"

#include <optional>
#include <sstream>

#include "state_struct.hpp"
#include "structs.hpp"

namespace haptic::c {

namespace {

constexpr std::uint64_t kLongest = 1'000'000'000'000;  // ns, of a limit on age: the scene's is less

/// `value` as an enumerator from 0 to `last`.
template <typename Enum>
Enum enumerator(const char* name, std::int32_t value, Enum last) {
  if (value < 0 || value > static_cast<std::int32_t>(last)) {
    refuse(std::string(name) + " = " + std::to_string(value) + ", must be 0 to " +
           std::to_string(static_cast<int>(last)));
  }
  return static_cast<Enum>(value);
}

/// Texts, apart by `by`.
std::string joined(const std::vector<std::string>& texts, char by) {
  std::string all;
  for (const std::string& text : texts) {
    if (!all.empty()) all += by;
    all += text;
  }
  return all;
}

std::optional<std::chrono::nanoseconds> limit(std::uint64_t ns) {
  if (ns == 0) return {};
  return std::chrono::nanoseconds(static_cast<std::int64_t>(std::min<std::uint64_t>(ns, kLongest)));
}

}  // namespace

haptic_device to_device(const client::DeviceInfo& device) {
  haptic_device to{};
  write_text(device.name, to.name);
  write_text(device.kind, to.kind);
  write_text(device.model, to.model);
  write_text(device.serial, to.serial);
  write_text(device.calibrated, to.calibrated);
  write_text(device.controller, to.controller);
  write_text(device.tracker, to.tracker);
  write_text(joined(device.unguarded, ' '), to.unguarded);
  to.moves = device.moves ? 1 : 0;
  to.wants_tracker = device.wants_tracker ? 1 : 0;
  to.measures_force = device.measures_force ? 1 : 0;
  to.state = static_cast<std::int32_t>(device.state);
  to.renderer = static_cast<std::int32_t>(device.renderer);
  to.faults = device.faults;
  to.observers = device.observers;
  write_list(device.stiffness_limit, to.stiffness_limit);
  write_list(device.damping_limit, to.damping_limit);
  write_list(device.force_limit, to.force_limit);
  write_list(device.slew_limit, to.slew_limit);
  write_list(device.engage_window, to.engage_window);
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
  write(state, to);
  return to;
}

haptic_server_info to_server_info(const client::ServerInfo& info) {
  haptic_server_info to{};
  write_text(info.version, to.version);
  write_text(info.protocol, to.protocol);
  write_text(info.scene, to.scene);
  write_text(info.realtime.grade, to.realtime_grade);
  write_text(info.realtime.explanation, to.realtime_explanation);
  write_text(joined(info.insecure, '\n'), to.insecure);
  to.ticks = info.loop.ticks;
  to.skipped_ticks = info.loop.skipped;
  to.records_dropped = info.loop.records_dropped;
  to.lateness_p50_us = info.loop.lateness_p50_us;
  to.lateness_p99_us = info.loop.lateness_p99_us;
  to.lateness_max_us = info.loop.lateness_max_us;
  to.tick_p50_us = info.loop.tick_p50_us;
  to.tick_p99_us = info.loop.tick_p99_us;
  write_text(info.loop.paced_by, to.paced_by);
  to.paced_by_sample = info.loop.paced_by_sample;
  to.uptime_ns = static_cast<std::uint64_t>(info.uptime.count());
  to.sessions = info.sessions;
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
  std::vector<std::string> why;
  for (const client::AppliedSettings::Clamp& clamp : settings.clamped) {
    std::ostringstream line;
    line << clamp.field << " = " << clamp.asked << ": " << clamp.applied << " applied, "
         << clamp.why;
    why.push_back(line.str());
  }
  write_text(joined(why, '\n'), to.why_clamped);
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
  to.tracker = options.tracker != 0;
  if (options.priority != 0) {
    to.priority = enumerator("options->priority", options.priority, client::Priority::kOperator);
  }
  if (options.nominal_rate_hz != 0.0) to.nominal_rate_hz = options.nominal_rate_hz;
  to.state_rate_hz = options.state_rate_hz;
  to.carriers = enumerator("options->carriers", options.carriers, client::Carriers::kUdpOnly);
  if (options.reconnect != 0) to.reconnect = client::Reconnect::kWithBackoff;
  to.re_engage = options.re_engage != 0;
  to.derive_planes = options.derive_planes != 0;
  if (options.block_count > 0) given(options.blocks, "options->blocks");
  to.blocks = to_blocks(options.blocks, options.block_count);
  to.fresh_end = limit(options.fresh_end_ns);
  to.hold_end = limit(options.hold_end_ns);
  to.fade_end = limit(options.fade_end_ns);
  if (options.timeout_ms != 0) to.timeout = std::chrono::milliseconds(options.timeout_ms);
  return to;
}

}  // namespace haptic::c
