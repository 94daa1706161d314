#include "convert.hpp"

namespace haptic::client {

namespace {

std::vector<Rejected> to_list(const google::protobuf::RepeatedPtrField<v1::Rejected>& field) {
  std::vector<Rejected> list;
  for (const v1::Rejected& entry : field) list.push_back({entry.reason(), entry.count()});
  return list;
}

std::optional<std::chrono::nanoseconds> known(bool present,
                                              const google::protobuf::Duration& duration) {
  if (!present) return std::nullopt;
  return to_duration(duration);
}

LinkDirection to_direction(const v1::LinkDirection& m) {
  return {.received = m.received(),
          .bytes = m.bytes(),
          .lost = m.lost(),
          .reordered = m.reordered(),
          .duplicate = m.duplicate(),
          .late = m.late(),
          .rejected = to_list(m.rejected()),
          .longest_gap = known(m.has_longest_gap(), m.longest_gap()),
          .jitter = known(m.has_jitter(), m.jitter())};
}

SessionLink to_link(const v1::SessionLink& m) {
  SessionLink link;
  link.device = m.device();
  link.client_name = m.client_name();
  link.observer = m.role() == v1::ROLE_OBSERVER;
  link.lease_epoch = m.lease_epoch();
  link.holds_lease = m.holds_lease();
  link.samples_by = static_cast<Carrier>(m.samples_by());
  link.states_by = static_cast<Carrier>(m.states_by());
  for (const v1::LinkTransport& t : m.transports()) {
    link.carriers.push_back({static_cast<Carrier>(t.transport()), to_direction(t.up()),
                             to_direction(t.down()), known(t.has_round_trip(), t.round_trip()),
                             known(t.has_least_round_trip(), t.least_round_trip())});
  }
  if (m.has_clock()) {
    link.clock = LinkClock{std::chrono::nanoseconds(m.clock().offset_ns()), m.clock().drift(),
                           to_duration(m.clock().bound()), m.clock().steps()};
  }
  link.age_p50 = known(m.has_age_p50(), m.age_p50());
  link.age_p99 = known(m.has_age_p99(), m.age_p99());
  link.age_error_bound = known(m.has_age_error_bound(), m.age_error_bound());
  link.aged_by_clock = m.aged_by_clock();
  return link;
}

}  // namespace

LinkReport to_report(const v1::GetLinkStatsResponse& message) {
  LinkReport report;
  for (const v1::SessionLink& session : message.sessions()) {
    report.sessions.push_back(to_link(session));
  }
  report.unassigned = to_list(message.unassigned());
  return report;
}

}  // namespace haptic::client
