#include <cinttypes>

#include "commands.hpp"
#include "convert.hpp"
#include "haptic/schema/fields.hpp"
#include "message_json.hpp"
#include "say.hpp"
#include "table.hpp"

namespace haptic::ctl {

namespace {

using nlohmann::json;
using schema::effort_unit;

json to_json(const client::ServerInfo& server) {
  v1::GetServerInfoResponse message;
  client::write(server, message);
  return ctl::to_json(message);
}

json to_json(const client::DeviceInfo& device) {
  v1::Device message;
  client::write(device, message);
  json all = ctl::to_json(message);
  all.erase("drawing");  // of the page alone
  all["faults"] = client::fault_names(device.faults);
  all["state_fields"] = json_fields(device);
  return all;
}

void print(const client::ServerInfo& s) {
  const client::LoopStatistics& loop = s.loop;
  say("hapticd %s (%s), scene \"%s\", up %.0f s, %u sessions\n", s.version, s.protocol, s.scene,
      std::chrono::duration<double>(s.uptime).count(), s.sessions);
  say("  %s: %s\n", s.realtime.grade, s.realtime.explanation);
  say("  loop: %" PRIu64 " ticks, %" PRIu64
      " skipped, late by %.1f us p50, %.1f us p99, "
      "%.1f us max; tick %.2f us p50, %.2f us p99\n",
      loop.ticks, loop.skipped, loop.lateness_p50_us, loop.lateness_p99_us, loop.lateness_max_us,
      loop.tick_p50_us, loop.tick_p99_us);
  if (!loop.paced_by.empty()) {
    say("  paced by %s: %" PRIu64 " ticks by its samples, %" PRIu64 " by the timer\n",
        loop.paced_by, loop.paced_by_sample, loop.ticks - loop.paced_by_sample);
  }
  for (const std::string& line : s.insecure) say("  insecure: %s\n", line);
}

void print(const client::DeviceInfo& d) {
  say("\n%s: %s (%s)%s\n", d.name, d.model, d.kind, d.moves ? "" : ", moves nothing");
  say("  %s, faults %s, controller %s, %u observers, %g Hz\n", client::name(d.state),
      joined(client::fault_names(d.faults)),
      d.controller.empty() ? std::string("none") : d.controller, d.observers, d.loop_rate_hz);
  if (!d.unguarded.empty()) say("  unguarded: no %s\n", joined(d.unguarded));
  if (d.wants_tracker) {
    say("  palm by a tracker: %s\n", d.tracker.empty() ? std::string("none") : d.tracker);
  }
  say("  %-12s %-4s %21s  %14s %16s %20s %12s\n", "DoF", "unit", "range",
      "stiffness <=", "damping <=", "force <= (spec)", "slew <=");
  std::size_t a = 0;  // actuated so far
  for (const auto& dof : d.dofs) {
    say("  %-12s %-4s %9.5f .. %8.5f", dof.name, dof.unit, dof.lower, dof.upper);
    if (dof.actuated && a < d.stiffness_limit.size()) {
      const std::string effort = effort_unit(dof.unit);
      const std::string& unit = dof.unit;
      say("  %7g %s/%-3s %7g %s s/%-3s %8g (%g) %s %8g %s/s\n", d.stiffness_limit[a], effort, unit,
          d.damping_limit[a], effort, unit, d.force_limit[a], dof.max_effort, effort,
          d.slew_limit[a], effort);
      ++a;
    } else {
      say("  sensed only\n");
    }
  }
  say("  virtual:");
  for (const auto& c : d.coordinates) say(" %s (%s)", c.name, c.unit);
  say("\n");
}

}  // namespace

int info(const Options& options) {
  client::Connection server = connect(options);
  const client::ServerInfo facts = server.server_info();
  const auto devices = meant(server, options.device);
  if (options.json) {
    json all = to_json(facts);
    all["devices"] = json::array();
    for (const auto& device : devices) all["devices"].push_back(to_json(device));
    say("%s\n", dump(all, 2).c_str());  // ASCII, of several lines
    return 0;
  }
  print(facts);
  for (const auto& device : devices) print(device);
  return 0;
}

}  // namespace haptic::ctl
