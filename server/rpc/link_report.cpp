#include "server/rpc/link_report.hpp"

#include <string>

#include "server/rpc/convert.hpp"
#include "server/rpc/session_stream.hpp"

namespace haptic::server {
namespace {

void add_rejected(const char* reason, std::uint64_t count,
                  google::protobuf::RepeatedPtrField<v1::Rejected>& list) {
  if (count == 0) return;
  v1::Rejected& entry = *list.Add();
  entry.set_reason(reason);
  entry.set_count(count);
}

void set_known(core::Duration value, google::protobuf::Duration* (v1::LinkDirection::*field)(),
               v1::LinkDirection& direction) {
  if (value > core::Duration(0)) set(*(direction.*field)(), value);
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

/// Datagrams, challenges among them; samples that the ingress refused by its reasons.
void report_udp(const CarrierFigures& figures, const UdpPath& path, v1::LinkTransport& udp) {
  udp.set_transport(v1::TRANSPORT_UDP);
  const wire::LinkCounters counters = path.counters();
  v1::LinkDirection& up = *udp.mutable_up();
  report_samples(figures, up);
  up.set_received(counters.received);
  up.set_bytes(counters.bytes);
  up.set_lost(counters.lost);
  up.set_reordered(counters.reordered);
  up.set_duplicate(counters.duplicate());
  up.set_late(counters.late());
  for (std::size_t i = 1; i < counters.rejected.size(); ++i) {
    add_rejected(wire::name(static_cast<wire::Rejection>(i)), counters.rejected[i],
                 *up.mutable_rejected());
  }
  set_known(counters.longest_gap, &v1::LinkDirection::mutable_longest_gap, up);
  const wire::PeerReport report = path.peer_report();
  udp.mutable_down()->set_received(report.received);
  udp.mutable_down()->set_lost(report.newest - report.received);
  set_round_trip(path.round_trip(), udp);
}

}  // namespace

void report_link(const LinkWatch& link, const UdpPath* path, bool holds_lease, core::TimePoint now,
                 v1::SessionLink& message) {
  v1::LinkTransport& stream = *message.add_transports();
  stream.set_transport(v1::TRANSPORT_GRPC);
  report_samples(link.figures(Carrier::kGrpc), *stream.mutable_up());
  stream.mutable_down()->set_received(link.figures(Carrier::kGrpc).states);
  set_round_trip(link.figures(Carrier::kGrpc).round_trip, stream);
  if (path != nullptr) report_udp(link.figures(Carrier::kUdp), *path, *message.add_transports());

  auto clock = link.clock().at(to_wire(now));
  const auto by_path = path != nullptr ? path->clock(now) : std::nullopt;
  if (by_path && (!clock || by_path->bound < clock->bound)) clock = by_path;
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

void report_unassigned(const UdpPort& port, v1::GetLinkStatsResponse& response) {
  for (std::size_t i = 1; i < wire::kRejections; ++i) {
    const auto why = static_cast<wire::Rejection>(i);
    add_rejected(wire::name(why), port.rejected(why), *response.mutable_unassigned());
  }
}

void SessionStream::report(const std::string& device, v1::GetLinkStatsResponse& response) {
  const std::lock_guard lock(mutex_);
  if (ended_ || !opened_) return;
  if (!device.empty() && device != target_.device->name()) return;
  v1::SessionLink& message = *response.add_sessions();
  message.set_device(target_.device->name());
  message.set_client_name(client_name_);
  message.set_role(role_);
  message.set_lease_epoch(epoch_);
  message.set_holds_lease(target_.device->holds_lease(id_));
  const bool samples = link_.figures(Carrier::kGrpc).samples + link_.figures(Carrier::kUdp).samples;
  if (samples) message.set_samples_by(static_cast<v1::Transport>(samples_by_));
  message.set_states_by(static_cast<v1::Transport>(states_by_));
  report_link(link_, udp_.get(), message.holds_lease(), context_.config.clock({}), message);
}

}  // namespace haptic::server
