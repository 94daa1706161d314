#include <cinttypes>

#include "commands.hpp"
#include "convert.hpp"
#include "message_json.hpp"
#include "say.hpp"

namespace haptic::ctl {

namespace {

using Time = std::optional<std::chrono::nanoseconds>;

double microseconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double, std::micro>(time).count();
}

/// In ms; "-" if it is not known.
std::string text(const Time& time) {
  if (!time) return "-";
  return ctl::text("%.3f", microseconds(*time) / 1e3);
}

std::string text(const std::vector<client::Rejected>& rejected) {
  std::vector<std::string> entries;
  entries.reserve(rejected.size());
  for (const client::Rejected& entry : rejected) {
    entries.push_back(entry.reason + " " + std::to_string(entry.count));
  }
  return joined(entries);
}

void print(const char* way, const client::LinkCarrier& t, const client::LinkDirection& d) {
  say("  %-5s %-4s %10" PRIu64 " %8" PRIu64 " %8" PRIu64 " %8" PRIu64 " %6" PRIu64 " %10s %8s\n",
      client::name(t.carrier), way, d.received, d.lost, d.reordered, d.duplicate, d.late,
      text(d.longest_gap), text(d.jitter));
  if (!d.rejected.empty()) say("             rejected: %s\n", text(d.rejected));
}

void print(const client::SessionLink& s) {
  const char* role = s.role == client::Role::kObserver ? "observer"
                     : s.holds_lease                   ? "controller"
                                                       : "lease over";
  say("\n%s: '%s', %s, lease epoch %u, samples by %s, states by %s\n", s.device, s.client_name,
      role, s.lease_epoch, client::name(s.samples_by), client::name(s.states_by));
  say("  %-5s %-4s %10s %8s %8s %8s %6s %10s %8s\n", "", "", "messages", "lost", "reorder",
      "repeat", "late", "gap ms", "jitter");
  for (const client::LinkCarrier& t : s.carriers) {
    print("up", t, t.up);
    print("down", t, t.down);
    say("  %-5s round trip %s ms, least %s ms\n", client::name(t.carrier), text(t.round_trip),
        text(t.least_round_trip));
  }
  say("  age at use p50 %s ms, p99 %s ms, at most %s ms too low; %" PRIu64 " by clock\n",
      text(s.age_p50), text(s.age_p99), text(s.age_error_bound), s.aged_by_clock);
  if (!s.clock) return;
  say("  clock offset %.6f s +- %.3f ms, drift %.1f ppm, %u steps\n",
      1e-9 * static_cast<double>(s.clock->offset_ns), microseconds(s.clock->bound) / 1e3,
      s.clock->drift * 1e6, s.clock->steps);
}

}  // namespace

int link(const Options& options) {
  client::Connection server = connect(options);
  const client::LinkReport report = server.links(options.device);
  if (options.json) {
    v1::GetLinkStatsResponse message;
    client::write(report, message);
    say("%s\n", dump(to_json(message), 2).c_str());
    return 0;
  }
  say("%zu sessions; datagrams of no session: %s\n", report.sessions.size(),
      text(report.unassigned));
  for (const client::SessionLink& session : report.sessions) print(session);
  return 0;
}

}  // namespace haptic::ctl
