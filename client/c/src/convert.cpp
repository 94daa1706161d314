#include "convert.hpp"

#include <optional>
#include <sstream>

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

std::optional<std::chrono::nanoseconds> limit(std::uint64_t ns) {
  if (ns == 0) return {};
  return std::chrono::nanoseconds(static_cast<std::int64_t>(std::min<std::uint64_t>(ns, kLongest)));
}

}  // namespace

haptic_settings to_settings(const client::AppliedSettings& settings) {
  haptic_settings to{};
  write_list(settings.stiffness, to.stiffness);
  write_list(settings.damping, to.damping);
  write_list(settings.force_limit, to.force_limit);
  write_list(settings.slew_limit, to.slew_limit);
  to.renderer = static_cast<std::int32_t>(settings.renderer);
  to.direction_guard = settings.direction_guard ? 1 : 2;
  to.clamped = static_cast<std::uint32_t>(settings.clamped.size());
  std::vector<std::string> why;
  for (const client::Clamp& clamp : settings.clamped) {
    std::ostringstream line;
    line << clamp.field << " = " << clamp.asked << ": " << clamp.applied << " applied, "
         << clamp.why;
    why.push_back(line.str());
  }
  write_text(joined(why), to.why_clamped);
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
