#include "server/front/session/link_report.hpp"

#include "server/front/session/messages.hpp"

namespace haptic::server {
namespace {

void set_known(core::Duration value, google::protobuf::Duration* (v1::LinkDirection::*field)(),
               v1::LinkDirection& direction) {
  if (value > core::Duration(0)) set(*(direction.*field)(), value);
}

}  // namespace

void add_rejected(const char* reason, std::uint64_t count,
                  google::protobuf::RepeatedPtrField<v1::Rejected>& list) {
  if (count == 0) return;
  v1::Rejected& entry = *list.Add();
  entry.set_reason(reason);
  entry.set_count(count);
}

void set_round_trip(const wire::RoundTrip& round_trip, v1::LinkTransport& transport) {
  if (!round_trip.known()) return;
  set(*transport.mutable_round_trip(), round_trip.smoothed());
  set(*transport.mutable_least_round_trip(), round_trip.least());
}

void report_samples(const CarrierFigures& figures, v1::LinkDirection& up) {
  up.set_received(figures.samples);
  up.set_bytes(figures.sample_bytes);
  for (std::size_t i = 0; i < figures.rejected.size(); ++i) {
    add_rejected(name(static_cast<IngressVerdict>(i)), figures.rejected[i], *up.mutable_rejected());
  }
  set_known(figures.longest_gap, &v1::LinkDirection::mutable_longest_gap, up);
  set_known(figures.jitter, &v1::LinkDirection::mutable_jitter, up);
}

void report_link(const LinkWatch& link, Carrier carrier,
                 const std::optional<wire::ClockOffset::Estimate>& path_clock, bool holds_lease,
                 core::TimePoint now, v1::SessionLink& message) {
  v1::LinkTransport& stream = *message.add_transports();
  stream.set_transport(static_cast<v1::Transport>(carrier));
  report_samples(link.figures(carrier), *stream.mutable_up());
  stream.mutable_down()->set_received(link.figures(carrier).states);
  set_round_trip(link.figures(carrier).round_trip, stream);

  auto clock = link.clock().at(to_wire(now));
  if (path_clock && (!clock || path_clock->bound < clock->bound)) clock = path_clock;
  if (clock) {
    v1::LinkClock& told = *message.mutable_clock();
    told.set_offset_ns(clock->offset.count());
    told.set_drift(clock->drift);
    told.set_steps(link.clock().steps());
    set(*told.mutable_bound(), clock->bound);
    // A sample that left at the latest moment the bound allows may have left twice that earlier.
    set(*message.mutable_age_error_bound(), 2 * clock->bound);
  }
  message.set_aged_by_clock(link.aged());
  const Percentiles ages = link.age_at_use();
  if (!holds_lease || ages.count == 0) return;
  set(*message.mutable_age_p50(), ages.p50);
  set(*message.mutable_age_p99(), ages.p99);
}

}  // namespace haptic::server
