#include <cinttypes>
#include <cstdio>

#include "commands.hpp"
#include "convert.hpp"
#include "message_json.hpp"

namespace haptic::ctl {

namespace {

using Time = std::optional<std::chrono::nanoseconds>;

double microseconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double, std::micro>(time).count();
}

/// In ms; "-" if it is not known.
std::string text(const Time& time) {
  if (!time) return "-";
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3f", microseconds(*time) / 1e3);
  return buffer;
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
  std::printf("  %-5s %-4s %10" PRIu64 " %8" PRIu64 " %8" PRIu64 " %8" PRIu64 " %6" PRIu64
              " %10s %8s\n",
              client::name(t.carrier), way, d.received, d.lost, d.reordered, d.duplicate, d.late,
              text(d.longest_gap).c_str(), text(d.jitter).c_str());
  if (!d.rejected.empty()) std::printf("             rejected: %s\n", text(d.rejected).c_str());
}

void print(const client::SessionLink& s) {
  const char* role = s.role == client::Role::kObserver ? "observer"
                     : s.holds_lease                   ? "controller"
                                                       : "lease over";
  std::printf("\n%s: '%s', %s, lease epoch %u, samples by %s, states by %s\n", s.device.c_str(),
              s.client_name.c_str(), role, s.lease_epoch, client::name(s.samples_by),
              client::name(s.states_by));
  std::printf("  %-5s %-4s %10s %8s %8s %8s %6s %10s %8s\n", "", "", "messages", "lost", "reorder",
              "repeat", "late", "gap ms", "jitter");
  for (const client::LinkCarrier& t : s.carriers) {
    print("up", t, t.up);
    print("down", t, t.down);
    std::printf("  %-5s round trip %s ms, least %s ms\n", client::name(t.carrier),
                text(t.round_trip).c_str(), text(t.least_round_trip).c_str());
  }
  std::printf("  age at use p50 %s ms, p99 %s ms, at most %s ms too low; %" PRIu64 " by clock\n",
              text(s.age_p50).c_str(), text(s.age_p99).c_str(), text(s.age_error_bound).c_str(),
              s.aged_by_clock);
  if (!s.clock) return;
  std::printf("  clock offset %.6f s +- %.3f ms, drift %.1f ppm, %u steps\n",
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
    std::printf("%s\n", to_json(message).dump(2).c_str());
    return 0;
  }
  std::printf("%zu sessions; datagrams of no session: %s\n", report.sessions.size(),
              text(report.unassigned).c_str());
  for (const client::SessionLink& session : report.sessions) print(session);
  return 0;
}

}  // namespace haptic::ctl
